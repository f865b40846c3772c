"""Seeded random URDFs: trees with axes anywhere, fixed links in between, sliding joints, mimics."""

import random

KINDS = ("revolute", "continuous", "prismatic", "fixed")
SPECIAL = ("0 0 1", "0 1 0", "1 0 0", "0 0 -1", "0 -1 0", "-1 0 0")
ANGLES = ("0", "0", "1.5708", "-1.57079632679", "3.14159", "0.7853981633974483", "-0.5235988")


def random_urdf(seed: int, mimics: bool = False) -> str:
    """Return the text of a URDF; its links and joints stand in a drawn order.

    Args:
        seed: same seed, same text.
        mimics: whether joints of a kind may follow earlier ones of that kind.
    """
    rng = random.Random(f"urdf {seed}")
    plain = rng.choice((0.0, 0.5, 0.9, 1.0))  # how special the geometry is

    def angle() -> str:
        return rng.choice(ANGLES) if rng.random() < plain else f"{rng.uniform(-3, 3):.3f}"

    def length() -> str:
        return "0" if rng.random() < 0.4 * plain else f"{rng.uniform(-0.5, 0.5):.3f}"

    def origin() -> str:
        xyz = " ".join(length() for _ in range(3))
        return f'<origin xyz="{xyz}" rpy="{angle()} {angle()} {angle()}"/>'

    def axis() -> str:
        if rng.random() < plain:
            return rng.choice(SPECIAL)
        return " ".join(f"{rng.uniform(-1, 1):.4f}" for _ in range(3))

    def link(name: str) -> str:
        if rng.random() < 0.15:
            return f'<link name="{name}"/>'
        diagonal = [rng.uniform(0.02, 0.03) for _ in range(3)]
        mixed = [rng.uniform(-0.004, 0.004) for _ in range(3)]
        keys = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), diagonal + mixed, strict=True)
        tensor = " ".join(f'{k}="{v:.5f}"' for k, v in keys)
        return (
            f'<link name="{name}"><inertial>{origin()}<mass value="{rng.uniform(0.1, 3):.3f}"/>'
            f"<inertia {tensor}/></inertial></link>"
        )

    links, joints = [link("base")], []
    names, masters = ["base"], []
    for i in range(rng.randint(2, 9)):
        kind = "revolute" if i == 0 else rng.choice(KINDS)
        extra = ""
        group = "p" if kind == "prismatic" else "r"
        if mimics and kind != "fixed" and rng.random() < 0.4:
            known = [name for name, g in masters if g == group]
            if known:
                factor, offset = rng.choice((-1, 0.5, 2)), rng.choice(("0", "1.5708", "0.2"))
                extra = (
                    f'<mimic joint="{rng.choice(known)}" multiplier="{factor}" offset="{offset}"/>'
                )
        if kind != "fixed":
            masters.append((f"j{i}", group))
        name, parent = f"link{i}", rng.choice(names[-2:])
        joints.append(
            f'<joint name="j{i}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>'
            f'{origin()}<axis xyz="{axis()}"/><limit lower="-3" upper="3" effort="9" '
            f'velocity="2"/>{extra}</joint>'
        )
        names.append(name)
        links.append(link(name))
    parts = links + joints
    rng.shuffle(parts)
    return '<?xml version="1.0"?>\n<robot name="drawn">\n' + "\n".join(parts) + "\n</robot>\n"

"""A 7R arm with a hand and two fingers: its URDF, and logs of it by Pinocchio, as recorders write.

Nothing is shared with the package under test: the text is written here, torques are Pinocchio's,
friction and rotors are added by hand.
"""

from __future__ import annotations

import numpy as np

from oracles.pinocchio_arm import load_pinocchio

ARM = [f"panda_joint{k}" for k in range(1, 8)]
FINGERS = ["panda_finger_joint1", "panda_finger_joint2"]
_ORIGINS = (  # xyz, rpy of joint 1 to 7
    ("0 0 0.333", "0 0 0"), ("0 0 0", "-1.5708 0 0"), ("0 -0.316 0", "1.5708 0 0"),
    ("0.0825 0 0", "1.5708 0 0"), ("-0.0825 0.384 0", "-1.5708 0 0"), ("0 0 0", "1.5708 0 0"),
    ("0.088 0 0", "1.5708 0 0"),
)  # fmt: skip
_LINKS = (  # mass, centre, principal inertia
    (3.2, (0.0, -0.03, -0.1), (0.05, 0.05, 0.01)), (3.0, (0.0, -0.08, 0.03), (0.04, 0.012, 0.04)),
    (2.8, (0.04, 0.03, -0.07), (0.03, 0.03, 0.01)), (2.7, (-0.04, 0.04, 0.02), (0.02, 0.01, 0.02)),
    (2.6, (0.0, 0.04, -0.1), (0.03, 0.03, 0.006)), (1.5, (0.05, 0.0, 0.0), (0.004, 0.006, 0.006)),
    (0.7, (0.01, 0.0, 0.08), (0.002, 0.002, 0.001)),
)  # fmt: skip
FS = np.array([0.6, 0.7, 0.5, 0.5, 0.3, 0.3, 0.2])
FV = np.array([1.0, 1.1, 0.8, 0.8, 0.5, 0.4, 0.3])
IA = np.array([0.5, 0.5, 0.4, 0.4, 0.15, 0.12, 0.1])
NOISE = np.array([0.3, 0.3, 0.25, 0.25, 0.08, 0.08, 0.06])  # N m
CLEARANCE = 0.02  # m, where the fingers stand


def urdf(heavier: float = 1.0, tool: tuple[float, tuple[float, ...]] | None = None) -> str:
    """Return the URDF; `heavier` scales all masses, `tool` is a point mass on the hand."""
    out = ['<?xml version="1.0"?>', '<robot name="panda">', '  <link name="panda_link0"/>']

    def link(name: str, mass: float, com: tuple[float, ...], inertia: tuple[float, ...]) -> None:
        xx, yy, zz = (heavier * i for i in inertia)
        out.append(
            f'  <link name="{name}">\n    <inertial>\n      <origin rpy="0 0 0" '
            f'xyz="{" ".join(map(str, com))}"/>\n      <mass value="{heavier * mass!r}"/>\n'
            f'      <inertia ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{zz!r}"/>\n'
            f'    </inertial>\n    <visual><geometry><mesh filename="{name}.dae"/></geometry>'
            "</visual>\n  </link>"
        )

    def joint(name: str, kind: str, parent: str, child: str, origin: str, rest: str) -> None:
        out.append(
            f'  <joint name="{name}" type="{kind}">\n    <parent link="{parent}"/>\n    '
            f'<child link="{child}"/>\n    {origin}\n    {rest}\n  </joint>'
        )

    for k, body in enumerate(_LINKS, 1):
        link(f"panda_link{k}", *body)
    link("panda_hand", 0.7, (0.0, 0.0, 0.04), (0.001, 0.0025, 0.0017))
    link("panda_leftfinger", 0.1, (0.0, 0.01, 0.02), (0.0002, 0.0002, 0.0001))
    link("panda_rightfinger", 0.1, (0.0, -0.01, 0.02), (0.0002, 0.0002, 0.0001))
    for k, (xyz, rpy) in enumerate(_ORIGINS, 1):
        low, high = (-3.05, 0.05) if k == 4 else (-0.05, 3.7) if k == 6 else (-2.8, 2.8)
        joint(
            ARM[k - 1], "revolute", f"panda_link{k - 1}", f"panda_link{k}",
            f'<origin rpy="{rpy}" xyz="{xyz}"/>',
            f'<axis xyz="0 0 1"/>\n    <limit effort="87" lower="{low}" upper="{high}" '
            'velocity="2.2"/>',
        )  # fmt: skip
    joint("panda_hand_joint", "fixed", "panda_link7", "panda_hand",
          '<origin rpy="0 0 -0.7854" xyz="0 0 0.107"/>', "")  # fmt: skip
    for name, child, axis, rest in (
        (FINGERS[0], "panda_leftfinger", "0 1 0", ""),
        (FINGERS[1], "panda_rightfinger", "0 -1 0", f'<mimic joint="{FINGERS[0]}"/>'),
    ):
        joint(
            name, "prismatic", "panda_hand", child, '<origin rpy="0 0 0" xyz="0 0 0.0584"/>',
            f'<axis xyz="{axis}"/>\n    <limit effort="20" lower="0.0" upper="0.04" '
            f'velocity="0.2"/>{rest}',
        )  # fmt: skip
    if tool is not None:
        mass, at = tool
        out.append(f'  <link name="tool"><inertial><origin xyz="{" ".join(map(str, at))}"/>'
                   f'<mass value="{mass!r}"/><inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" '
                   'iyz="0" izz="0.004"/></inertial></link>')  # fmt: skip
        joint("tool_joint", "fixed", "panda_link7", "tool", '<origin xyz="0 0 0"/>', "")
    return "\n".join([*out, "</robot>", ""])


def recorded(text: str, seed: int, seconds: float = 30.0, rate: float = 250.0) -> str:
    """Return a CSV as a recorder writes it: its own names, stamps that jitter by up to a tenth.

    Args:
        text: the URDF that moves.
        seed: of the motion and of the noise.
    """
    pin = load_pinocchio()
    model = pin.buildModelFromXML(text)
    model.armature[:] = model.friction[:] = model.damping[:] = 0
    data = model.createData()
    rng = np.random.default_rng(seed)
    t = np.arange(0, seconds, 1 / rate)
    middle = np.array([0, 0, 0, -1.5, 0, 1.8, 0])
    reach = np.array([2.0, 1.4, 2.0, 1.2, 2.2, 1.6, 2.4])
    w = 2 * np.pi * np.arange(1, 6) / 10.0
    a, b = rng.normal(size=(2, 5, 7))
    size = reach / np.sum(np.hypot(a, b), axis=0)
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    q = middle + size * (s @ a + c @ b)
    qd = size * ((w * c) @ a - (w * s) @ b)
    qdd = size * (-(w**2 * s) @ a - (w**2 * c) @ b)
    still = np.zeros(2)
    tau = np.array([
        pin.rnea(model, data, np.append(x, [CLEARANCE] * 2), np.append(v, still),
                 np.append(u, still))[:7]
        for x, v, u in zip(q, qd, qdd, strict=True)
    ])  # fmt: skip
    tau += FS * np.sign(qd) + FV * qd + IA * qdd + NOISE * rng.standard_normal(tau.shape)
    q = q + 1e-5 * rng.standard_normal(q.shape)
    qd = qd + 2e-3 * rng.standard_normal(qd.shape)
    stamps = 1.7e9 + t + rng.uniform(-0.1, 0.1, len(t)) / rate
    names = ["time"] + [f"{j}_{w}" for j in ARM for w in ("position", "velocity", "effort")]
    values = np.stack([q, qd, tau], axis=2).reshape(len(t), -1)
    rows = [",".join([f"{x:.6f}", *(f"{v:.9g}" for v in row)])
            for x, row in zip(stamps, values, strict=True)]  # fmt: skip
    return "\n".join([",".join(names), *rows]) + "\n"

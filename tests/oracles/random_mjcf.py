"""Random MJCF files of what MuJoCo's reference documents, and their torques by MuJoCo alone."""

from __future__ import annotations

import mujoco
import numpy as np

#: Content that symgen names, with the word of its note.
NAMED = {"density": "medium", "gravcomp": "gravcomp", "tendon": "tendons"}


def vector(draw: np.random.Generator, size: float, count: int = 3) -> str:
    return " ".join(f"{x:.4f}" for x in draw.uniform(-size, size, count))


def joint(draw: np.random.Generator, name: str, follower: bool) -> str:
    """A hinge or slide with some of the losses, springs and offsets that a joint can have."""
    words = [f'name="{name}"', f'axis="{vector(draw, 1.0)}"', f'pos="{vector(draw, 0.1)}"']
    words.append(f'type="{"hinge" if follower else draw.choice(["hinge", "hinge", "slide"])}"')
    options = [
        f'armature="{draw.uniform(0, 0.2):.4f}"',
        f'damping="{draw.uniform(0, 1):.4f}"',
        f'frictionloss="{draw.uniform(0, 1):.4f}"',
        f'stiffness="{draw.uniform(1, 9):.4f}" springref="{draw.uniform(-0.5, 0.5):.4f}"',
    ]
    if not follower:
        options += [
            f'damping="{draw.uniform(0, 1):.4f} {vector(draw, 0.5, 2)}"',
            f'stiffness="{draw.uniform(1, 9):.4f} {vector(draw, 2.0, 2)}"',
            f'ref="{draw.uniform(-0.5, 0.5):.4f}"',
        ]
    taken: dict[str, str] = {}
    for option in draw.permutation(options)[: draw.integers(0, 4)]:
        taken.setdefault(option.split("=")[0], option)
    return f"<joint {' '.join([*words, *taken.values()])}/>"


def body(draw: np.random.Generator, k: int, inner: str, follower: bool) -> str:
    """A link with its inertia as numbers or from a geom, in a frame or not."""
    a, b = draw.uniform(0.01, 0.03, 2)
    inertia = (
        f'<inertial pos="{vector(draw, 0.2)}" euler="{vector(draw, 60.0)}" '
        f'mass="{draw.uniform(0.3, 3):.4f}" diaginertia="{a:.5f} {b:.5f} {0.9 * (a + b):.5f}"/>'
    )
    if draw.random() < 0.3:
        inertia = f'<geom type="box" size="0.05 0.04 0.2" pos="{vector(draw, 0.2)}" density="300"/>'
    pose = f'pos="{vector(draw, 0.4)}" euler="{vector(draw, 90.0)}"'
    own = f'<body name="link{k}" {pose}>{joint(draw, f"j{k}", follower)}{inertia}{inner}</body>'
    return f'<frame euler="{vector(draw, 30.0)}">{own}</frame>' if draw.random() < 0.2 else own


def mjcf(seed: int) -> tuple[str, list[str]]:
    """A chain of two to four joints; the text and the words of what symgen has to name."""
    draw = np.random.default_rng(seed)
    count, named = int(draw.integers(2, 5)), []
    follows = draw.random() < 0.3
    links = ""
    for k in reversed(range(count)):
        links = body(draw, k, links, follows and k >= count - 2)
    sections, options, flags = [], [], []
    actuators = [
        f'<{draw.choice(["motor", "general"])} joint="j{k}" gear="{draw.uniform(1, 60):.3f}" '
        f'armature="{draw.uniform(0, 1e-4):.6f}" damping="{draw.uniform(0, 1e-4):.6f}"/>'
        for k in range(count)
        if draw.random() < 0.5
    ]
    if draw.random() < 0.3:
        actuators.append('<position joint="j0" kp="30" kv="2"/>')
    if follows:
        factor = f"{draw.uniform(0.3, 1):.4f}"
        sections.append(
            f'<equality><joint joint1="j{count - 1}" joint2="j{count - 2}" '
            f'polycoef="0.1 {factor} 0 0 0"/></equality>'
        )
    elif draw.random() < 0.3:
        stiff = 'stiffness="5"' if draw.random() < 0.3 else ""
        sections.append(
            f'<tendon><fixed name="t" armature="0.02" damping="0.1" {stiff}><joint joint="j0" '
            'coef="1"/><joint joint="j1" coef="-0.5"/></fixed></tendon>'
        )
        actuators.append('<motor tendon="t" gear="3" armature="1e-3" damping="0.02"/>')
        if stiff:
            named.append(NAMED["tendon"])
    if draw.random() < 0.2:
        flags.append(f'{draw.choice(["damper", "spring", "frictionloss"])}="disable"')
    if draw.random() < 0.1:
        options.append('density="1.2" viscosity="0.1"')
        named.append(NAMED["density"])
    if draw.random() < 0.1:
        links = links.replace("<body ", '<body gravcomp="0.5" ', 1)
        named.append(NAMED["gravcomp"])
    default = '<default><joint damping="0.3" armature="0.05"/></default>'
    return (
        f'<mujoco model="arm{seed}"><option gravity="{vector(draw, 2.0, 2)} -9.81" '
        f"{' '.join(options)}><flag {' '.join(flags)}/></option>"
        f"{default if draw.random() < 0.3 else ''}<worldbody>{links}</worldbody>"
        f"{''.join(sections)}<actuator>{''.join(actuators)}</actuator></mujoco>"
    ), named


def torques(
    text: str, names: list[str], q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
) -> np.ndarray:
    """Torques of the file by mj_inverse, with Coulomb friction as a sign, (N, n).

    A joint that an equality couples moves with its leader, and its torque counts there.
    """
    model = mujoco.MjModel.from_xml_string(text)
    flags = model.opt.disableflags
    off = mujoco.mjtDisableBit
    rubs = not flags & (int(off.mjDSBL_FRICTIONLOSS) | int(off.mjDSBL_CONSTRAINT))
    coulomb = model.dof_frictionloss * rubs
    model.dof_frictionloss[:] = model.tendon_frictionloss[:] = 0
    model.opt.disableflags = flags | int(off.mjDSBL_CONSTRAINT)
    data, n = mujoco.MjData(model), model.nv
    leads, offset = np.zeros((n, len(names))), np.zeros(n)
    for j, name in enumerate(names):
        leads[model.joint(name).dofadr[0], j] = 1.0
    for k in range(model.neq):
        follower, leader = (int(x[k]) for x in (model.eq_obj1id, model.eq_obj2id))
        a0, a1 = model.eq_data[k][:2]
        y, x = model.qpos0[[follower, leader]]
        leads[follower] = a1 * leads[leader]
        offset[follower] = y + a0 - a1 * x
    out = []
    for place, speed, rate in zip(q, qd, qdd, strict=True):
        data.qpos[:], data.qvel[:] = leads @ place + offset, leads @ speed
        data.qacc[:] = leads @ rate
        mujoco.mj_inverse(model, data)
        out.append(leads.T @ (data.qfrc_inverse + coulomb * np.sign(data.qvel)))
    return np.array(out)

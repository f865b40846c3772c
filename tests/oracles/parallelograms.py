"""Random arms with a parallelogram that a <connect> closes, and their torques by MuJoCo alone."""

from __future__ import annotations

import mujoco
import numpy as np

#: Layouts of the tree: body -> parent and pivot. The last two entries are the cut.
LAYOUTS = {
    "two and one": ({"crank": ("turn", 0), "rod": ("crank", 1), "rocker": ("turn", 3)},
                    ("rod", "rocker"), 2, {"rod", "rocker"}),
    "driven rocker": ({"rocker": ("turn", 3), "crank": ("turn", 0), "rod": ("crank", 1)},
                      ("rocker", "rod"), 2, {"rod", "crank"}),
    "three": ({"crank": ("turn", 0), "rod": ("crank", 1), "rocker": ("rod", 2)},
              ("rocker", "turn"), 3, {"rod", "rocker"}),
    "to the world": ({"crank": ("world", 0), "rod": ("crank", 1), "rocker": ("rod", 2)},
                     ("rocker", "world"), 3, {"rod", "rocker"}),
    "palletizer": ({"upper": ("turn", 0), "crank": ("turn", 0), "rod": ("crank", 1),
                    "rocker": ("upper", 3)}, ("rod", "rocker"), 2, {"rod", "rocker"}),
}  # fmt: skip
MISSES = ("longer", "tilted", "crossed")


def rotation(draw: np.random.Generator) -> np.ndarray:
    Q, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    return Q * np.linalg.det(Q)


def mjcf(seed: int, layout: str, miss: str = "", digits: int = 17) -> str:
    """Text of an arm; its passive joints have losses where they follow one joint."""
    draw = np.random.default_rng(seed)
    bodies, cut, where, passive = LAYOUTS[layout]
    plane, origin = rotation(draw), draw.uniform(-0.3, 0.3, 3)
    turn = draw.uniform(0.6, 2.5)
    a = draw.uniform(0.1, 0.3) * np.array([np.cos(turn), np.sin(turn), 0])
    b = np.array([draw.uniform(0.3, 0.6), 0, 0])
    pivots = [0 * a, a, a + b, b]
    if miss == "longer":
        pivots[2] = pivots[2] + 0.01 * (pivots[2] - pivots[3])
    if miss == "crossed":  # mirrored in the diagonal from 0 to 2, so that lengths stay equal
        e = (a + b) / np.linalg.norm(a + b)
        pivots[3] = 2 * (b @ e) * e - b
    pivots = [origin + plane @ pivot for pivot in pivots]

    def words(values) -> str:
        return " ".join(f"{x:.{digits}f}" for x in np.ravel(values))

    frames = {"world": (np.eye(3), np.zeros(3))}
    inner = dict.fromkeys(("world", "turn", *bodies, "tool"), "")
    tree = {"turn": ("world", None), **bodies, "tool": ("rocker", None)}
    for name in tree:
        frames[name] = rotation(draw), draw.uniform(-0.3, 0.3, 3)
    heads = {}
    for name, (parent, pivot) in tree.items():
        (R, o), (P, at) = frames[name], frames[parent]
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, (P.T @ R).ravel())
        axis, point = draw.normal(size=3), draw.uniform(-0.1, 0.1, 3)
        if name == "turn" and draw.random() < 0.7:
            axis = R.T @ (plane[:, 2] if draw.random() < 0.3 else plane[:, :2] @ axis[:2])
        if pivot is not None:
            tilt = 0.02 if miss == "tilted" and name == "rod" else 0.0
            along = plane @ [np.sin(tilt), 0, np.cos(tilt)] * draw.choice([-1, 1])
            axis = R.T @ along
            point = R.T @ (pivots[pivot] + draw.uniform(-0.1, 0.1) * plane[:, 2] - o)
        losses = f'armature="{draw.uniform(0, 0.1):.4f}" damping="{draw.uniform(0, 1):.4f}"'
        losses = "" if layout == "palletizer" and name in passive else losses
        x, y = draw.uniform(0.01, 0.03, 2)
        heads[name] = (
            f'<body name="{name}" pos="{words(P.T @ (o - at))}" quat="{words(quat)}">'
            f'<joint name="{name}" axis="{words(axis)}" pos="{words(point)}" {losses} '
            f'ref="{draw.uniform(-0.5, 0.5):.4f}"/>'
            f'<inertial pos="{words(draw.uniform(-0.2, 0.2, 3))}" '
            f'quat="{words(draw.normal(size=4))}" mass="{draw.uniform(0.3, 3):.4f}" '
            f'diaginertia="{x:.5f} {y:.5f} {0.9 * (x + y):.5f}"/>'
        )
    for name, (parent, _) in reversed(tree.items()):
        inner[parent] += f"{heads[name]}{inner[name]}</body>"
    R, o = frames[cut[0]]
    motors = "".join(f'<motor joint="{name}"/>' for name in tree if name not in passive)
    return (
        '<mujoco model="arm"><compiler angle="radian"/><option gravity="1 2 -9.81"/>'
        f'<worldbody>{inner["world"]}</worldbody><equality><connect name="bar" body1="{cut[0]}" '
        f'body2="{cut[1]}" anchor="{words(R.T @ (pivots[where] - o))}"/></equality>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


class Closed:
    """An arm whose loops are closed by Newton's method."""

    def __init__(self, text: str, names: list[str]) -> None:
        self.model = mujoco.MjModel.from_xml_string(text)
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
        self.data = mujoco.MjData(self.model)
        self.free = [int(self.model.joint(name).qposadr[0]) for name in names]
        self.bound = [k for k in range(self.model.nv) if k not in self.free]

    def _gap(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances of the anchors of each loop, and their Jacobian."""
        m, data = self.model, self.data
        data.qpos[:] = q
        mujoco.mj_kinematics(m, data)
        mujoco.mj_comPos(m, data)
        gaps, rows = [], []
        for k in range(m.neq):
            points, jacobians = [], []
            for body, at in zip((m.eq_obj1id[k], m.eq_obj2id[k]), (0, 3), strict=True):
                R = data.xmat[body].reshape(3, 3)
                points.append(data.xpos[body] + R @ m.eq_data[k][at : at + 3])
                jacobians.append(np.zeros((3, m.nv)))
                mujoco.mj_jac(m, data, jacobians[-1], None, points[-1], body)
            gaps.append(points[0] - points[1])
            rows.append(jacobians[0] - jacobians[1])
        return np.concatenate(gaps), np.vstack(rows)

    def _rates(self, q: np.ndarray) -> np.ndarray:
        """dq/dq_free with the loops closed."""
        _, J = self._gap(q)
        G = np.zeros((len(q), len(self.free)))
        G[self.free] = np.eye(len(self.free))
        G[self.bound] = -np.linalg.pinv(J[:, self.bound], rcond=1e-3) @ J[:, self.free]
        return G

    def torques(self, positions, speeds, rates) -> np.ndarray:
        """Torques of the free joints, from mj_inverse of the tree; reached in small steps."""
        out = []
        start = self.model.qpos0.copy()
        for x, v, a in zip(positions, speeds, rates, strict=True):
            q = start.copy()
            for share in np.linspace(0, 1, 60)[1:]:
                q[self.free] = start[self.free] + share * (x - start[self.free])
                for _ in range(4):
                    gap, J = self._gap(q)
                    q[self.bound] -= np.linalg.pinv(J[:, self.bound], rcond=1e-3) @ gap
            h, G = 1e-4, self._rates(q)
            change = (self._rates(q + h * G @ v) - self._rates(q - h * G @ v)) / (2 * h)
            self.data.qpos[:], self.data.qvel[:] = q, G @ v
            self.data.qacc[:] = G @ a + change @ v
            mujoco.mj_inverse(self.model, self.data)
            out.append(G.T @ self.data.qfrc_inverse)
        return np.array(out)

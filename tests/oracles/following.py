"""Arms of which some joints follow others: q_tree = G q + c, with G and c drawn here."""

import random
from dataclasses import dataclass

import numpy as np

from oracles.numeric_rank import numeric_rank
from oracles.random_arms import random_arm, to_toml
from oracles.transforms import FIXED, REVOLUTE, Arm, energy_regressor

RATIOS = (1, -1, -1, 2, -3, 0.5, -1.5)


@dataclass(frozen=True)
class FollowingArm:
    """A tree with G (tree joints that move, own variables) and c; `text` is its robot.toml."""

    arm: Arm
    own: tuple[int, ...]
    G: np.ndarray
    c: np.ndarray
    text: str

    def rotors(self) -> tuple[bool, ...]:
        """Flags of rotor inertia, by joint of the file."""
        return tuple(j in self.own for j in range(1, self.arm.links + 1))

    def count_base_parameters(self) -> int:
        """Rank of random energy differences of states that the joints can reach."""
        draw = np.random.default_rng(0)
        samples = 40 + 22 * self.arm.links
        q = draw.uniform(-np.pi, np.pi, (samples, len(self.own)))
        qd = draw.uniform(-2, 2, q.shape)
        h = energy_regressor(self.arm, q @ self.G.T + self.c, qd @ self.G.T, self.rotors())
        return numeric_rank(h[1:] - h[0])


def following_arm(seed: int, max_joints: int = 6, tree: bool | None = None) -> FollowingArm:
    """Draw an arm with at least one joint of its own and, mostly, some that follow."""
    rng = random.Random(f"following {seed}")
    arm = random_arm(500_000 + seed, min_joints=3, max_joints=max_joints, tree=tree)
    moving = [j for j in range(1, arm.links + 1) if arm.sigma[j - 1] != FIXED]
    own = sorted({moving[0], *(j for j in moving if rng.random() < 0.4)})
    G = np.zeros((len(moving), len(own)))
    c = np.zeros(len(moving))
    follows = {}
    for row, j in enumerate(moving):
        turns = arm.sigma[j - 1] == REVOLUTE
        masters = [k for k in own if not turns or arm.sigma[k - 1] == REVOLUTE]
        if j in own:
            G[row, own.index(j)] = 1
            continue
        if not masters:  # a revolute joint finds no revolute one to follow: draw another arm
            return following_arm(seed + 1_000, max_joints, tree)
        chosen = {masters[int(rng.random() * len(masters))] for _ in range(2)}
        for k in chosen:
            G[row, own.index(k)] = RATIOS[int(rng.random() * len(RATIOS))]
        c[row] = (0.0, np.pi / 2, -0.3)[int(rng.random() * 3)]
        terms = [f"{float(G[row, own.index(k)])!r}*q{k}" for k in sorted(chosen)]
        follows[j] = " + ".join([*terms, repr(float(c[row]))])
    rotor = tuple(j in own for j in range(1, arm.links + 1))
    friction = [("coulomb", "viscous") if flag else () for flag in rotor]
    blocks = to_toml(arm, "arm", friction, rotor).split("[[joint]]\n")
    for j, text in follows.items():
        blocks[j] = f'follows = "{text}"\n' + blocks[j]
    return FollowingArm(arm, tuple(own), G, c, "[[joint]]\n".join(blocks))

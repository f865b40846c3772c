"""The torque of the links of a robot with other lengths and another gravity than in its file.

One tape has all standard parameters of the links, all nonzero lengths, and gravity as symbols. It
also contains parameters without an effect in the geometry of the file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from symgen import names
from symgen.data.raw import FloatArray
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameter, BaseParameters, Proof
from symgen.symbolic.dynamics import inverse_dynamics, plant
from symgen.symbolic.kinematics import carriers
from symgen.symbolic.parameters import standard_parameters
from symgen.symbolic.sampling import FUNCTIONS
from symgen.symbolic.tape import Numbers, Tape, real_symbol

_LENGTHS = ("d", "r", "b")
_UNPROVED = Proof(0, (), (), 0, 0, 0)


@dataclass(frozen=True, eq=False)
class Variation:
    """The torque of a robot's links, without friction and rotors, for any lengths and gravity."""

    robot: Robot

    @cached_property
    def _plain(self) -> Robot:
        return self.robot.with_values()

    @cached_property
    def lengths(self) -> tuple[tuple[int, str], ...]:
        """Number of the joint and key of every length that is not zero, as ("d", "r", "b").

        The lengths of fixed joints that carry no moving joint are left out.
        """
        carrying = carriers(self.robot)
        return tuple(
            (joint.number, key)
            for joint in self._plain.joints
            for key in _LENGTHS
            if joint.number in carrying and getattr(joint, key) != 0
        )

    @cached_property
    def gravity(self) -> FloatArray:
        """Gravity in frame 0, (3,), m/s2."""
        return np.array([float(g) for g in self._plain.gravity])

    @property
    def units(self) -> FloatArray:
        """Unit vectors of the parameters of the moving links, (10 links, links, 10)."""
        count = len(self.robot.moving)
        return np.eye(count * len(names.LINK)).reshape(-1, count, len(names.LINK))

    def torque(
        self,
        state: Sequence[FloatArray],
        links: FloatArray,
        gravity: FloatArray | None = None,
        changes: Mapping[tuple[int, str], float] | None = None,
    ) -> FloatArray:
        """Return the torque of the links.

        Args:
            state: q, qd, qdd, (..., n) each; rad or m and so on. If the base has an IMU, also its
                motion f, w, wd, (..., 3) each.
            links: XX XY XZ YY YZ ZZ MX MY MZ M of every moving link, including fixed ones in it,
                (..., links, 10). The leading axes are broadcast against those of the state.
            gravity: gravity in frame 0, (3,), m/s2; None for that of the file.
            changes: changes of the lengths, m.

        Returns:
            (..., n), N m or N.
        """
        field = self.gravity if gravity is None else gravity
        arithmetic = _arithmetic(self, tuple(map(float, field)), tuple((changes or {}).items()))
        inputs = {
            name: [x[..., i] for i in range(x.shape[-1])]
            for name, x in zip(("q", "qd", "qdd", *names.BASE), state, strict=False)
        }
        flat = links.reshape(*links.shape[:-2], -1)
        inputs["X"] = [flat[..., i] for i in range(flat.shape[-1])]
        out = self._tape.run(arithmetic, inputs)
        shape = np.broadcast_shapes(state[0].shape[:-1], flat.shape[:-1])
        return np.stack([np.broadcast_to(np.asarray(x, float), shape) for x in out], axis=-1)

    def regressor(
        self,
        state: Sequence[FloatArray],
        links: FloatArray,
        gravity: FloatArray | None = None,
    ) -> FloatArray:
        """Return the torque (N, n, m) of m sets of link parameters (m, links, 10), see `torque`."""
        across = [x[:, None, :] for x in state]
        return self.torque(across, links, gravity).transpose(0, 2, 1)

    @cached_property
    def _values(self) -> dict[sp.Symbol, sp.Expr]:
        joints = self._plain.joints
        return {_symbol(j, key): getattr(joints[j - 1], key) for j, key in self.lengths}

    @cached_property
    def _tape(self) -> Tape:
        plain = self._plain
        free = set(self.lengths)
        joints = tuple(
            replace(
                joint,
                **{k: _symbol(joint.number, k) for k in _LENGTHS if (joint.number, k) in free},
                friction=(),
                rotor_inertia=False,
            )
            for joint in plain.joints
        )
        gravity = tuple(_gravity(axis) for axis in "xyz")
        robot = replace(
            plain,
            gravity=gravity,
            joints=joints,
            couplings=(),
            payload=None,
            effects=(),
            # Names that steps of the tape must not have; their values come with each run.
            geometry=tuple((s.name, sp.S.One) for s in (*gravity, *self._values)),
        )
        every = standard_parameters(robot)
        standard = tuple(p for p in every if not robot.joint(p.joint).fixed)
        own = tuple(BaseParameter(p.name, i, (), p.unit, True) for i, p in enumerate(standard))
        p = plant(robot, BaseParameters(own, standard, (), _UNPROVED))
        torque = inverse_dynamics(p)
        return p.close(("q", "qd", "qdd"), [torque[j] for j in p.numbers])


@lru_cache(maxsize=64)
def _arithmetic(
    v: Variation, gravity: tuple[float, ...], changes: tuple[tuple[tuple[int, str], float], ...]
) -> Numbers:
    """Return floats that cache the constants of one geometry and gravity."""
    values = dict(v._values)
    for key, change in changes:
        values[_symbol(*key)] += change
    for axis, g in zip("xyz", gravity, strict=True):
        values[_gravity(axis)] = sp.Float(g, 20)
    return Numbers(values, FUNCTIONS, digits=17)


def link_values(robot: Robot, base: BaseParameters, X: FloatArray) -> FloatArray:
    """Return parameters of the moving links, (links, 10), with base parameters X (p,).

    Leading parameters have the values of their base parameters; all others are zero. The difference
    from the true set has no torque in the geometry and gravity of the model.
    """
    out = np.zeros((len(robot.moving), len(names.LINK)))
    at = {joint.number: i for i, joint in enumerate(robot.moving)}
    for value, p in zip(X, base.parameters, strict=True):
        standard = base.standard[p.index]
        if standard.prefix in names.LINK and standard.joint in at:
            out[at[standard.joint], names.LINK.index(standard.prefix)] += value
    return out


@lru_cache(maxsize=4)
def variation(robot: Robot) -> Variation:
    """Return the variation of a robot; its tape is derived in the first run."""
    return Variation(robot)


def _symbol(joint: int, key: str) -> sp.Symbol:
    return real_symbol(f"length_{key}{joint}")


def _gravity(axis: str) -> sp.Symbol:
    return real_symbol(f"gravity_{axis}")

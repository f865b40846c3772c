"""Inverse and forward dynamics and their parts, in base parameters X.

Inverse dynamics follows Newton and Euler in link frames (Luh, Walker and Paul 1980, in the base
parameters of Khalil and Kleinfinger 1987). The mass matrix uses composite bodies (Walker and Orin
1982). Coriolis torques use a second, virtual velocity, with the factor of Christoffel symbols,
which keeps M' - 2 C skew-symmetric (Niemeyer and Slotine 1991, in body coordinates).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.bodies import Inertia, composites
from symgen.symbolic.constraints import (
    ByJoint,
    Rows,
    add_to,
    combined,
    congruent,
    spread,
    to_variables,
)
from symgen.symbolic.effects import effect_columns
from symgen.symbolic.energy import separate_columns
from symgen.symbolic.kinematics import (
    Way,
    arrays,
    axes,
    builder,
    path,
    variables,
    way_of,
)
from symgen.symbolic.motion import (
    AT_REST,
    Letters,
    LinkState,
    accelerations,
    base_acceleration,
    references,
    wrench_on_antecedent,
)
from symgen.symbolic.spatial import ZERO, Screw, Vector, acting, named, plus
from symgen.symbolic.tape import Symbols, Tape, TapeBuilder, real_symbol

Wrenches = dict[int, Screw]


@dataclass(frozen=True)
class Plant:
    """A robot with symbols for its base parameters, the steps to its joints, and its mounting."""

    robot: Robot
    base: BaseParameters
    tape: TapeBuilder
    way: Way
    mounting: LinkState
    X: Symbols

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of the movable joints."""
        return self.robot.numbers

    @property
    def equations(self) -> tuple[int, ...]:
        """Numbers of the equations: of a free base, then of the movable joints."""
        return self.robot.equations

    def value(self, name: str) -> sp.Expr:
        """Return the symbol of the base parameter with this leading parameter; 0 without one."""
        return self._led.get(name, sp.S.Zero)

    @cached_property
    def _led(self) -> Mapping[str, sp.Symbol]:
        heads = (p.head for p in self.base.parameters)
        return dict(zip(heads, self.X, strict=True))

    @cached_property
    def bodies(self) -> Mapping[int, Inertia]:
        """The bodies of all links in base parameters, by joint number; a free base is link 0."""
        return {
            j.number: Inertia.of(
                {prefix: self.value(f"{prefix}{j.number}") for prefix in names.LINK}
            )
            for j in self.robot.bodies
        }

    def momenta(self, moving: Mapping[int, LinkState]) -> Wrenches:
        """Return the momentum (l, k) of every link, by joint number."""
        out = {}
        for j, body in self.bodies.items():
            lin, ang = body.momentum(moving[j].twist)
            name = self.namer(f"{j}")
            out[j] = name(lin, "l"), name(ang, "k")
        return out

    def namer(self, tag: str) -> Callable[[Vector, str], Vector]:
        """Return a function that names vectors by a letter and a tag."""
        return lambda vector, letter: named(vector, f"{letter}{tag}_", self.tape)

    def still(self) -> Plant:
        """Return the plant with all speeds zero, and those of a free base."""
        mounting = self.mounting
        if self.robot.floating:
            mounting = LinkState(ZERO, mounting.a)
        return replace(self, way=tuple(s.still() for s in self.way), mounting=mounting)

    def unforced(self) -> Plant:
        """Return the plant; a free base has only its angular velocity."""
        if not self.robot.floating:
            return self
        return replace(self, mounting=LinkState(ZERO, ZERO, w=self.mounting.w))

    def close(
        self, inputs: Sequence[str], outputs: Sequence[sp.Expr], count: int | None = None
    ) -> Tape:
        """Return the tape; X is the last input, or its first `count` entries."""
        return self.tape.tape([*arrays(self.robot, *inputs), ("X", self.X[:count])], outputs)


def plant(robot: Robot, base: BaseParameters) -> Plant:
    """Begin a tape of a robot in its base parameters."""
    X = tuple(real_symbol(f"X_{p.name}") for p in base.parameters)
    tape = builder(robot, X)
    return Plant(robot, base, tape, way_of(robot, tape), base_acceleration(robot, tape), X)


def inverse_dynamics(p: Plant) -> ByJoint:
    """Return the force and moment on a free base, and the torque of every movable joint.

    Load effects depend on the rigid-body torque at this motion, rotors included.
    """
    return in_all(p, rigid_torques(p, variables(p.robot, "qdd")))


def bias_torque(p: Plant) -> ByJoint:
    """Return the torque of every movable joint without accelerations, C qd + g + friction.

    For a free base, gravity belongs to f. Its equations come first.
    """
    return in_all(p, bias(p))


def bias(p: Plant) -> ByJoint:
    """Return the torque of links and rotors without accelerations, and without f of a free base."""
    return rigid_torques(p.unforced(), {})


def in_all(p: Plant, rigid: ByJoint) -> ByJoint:
    """Return the torque of the rigid body plus that of friction and effects."""
    load = loads(p, rigid)
    torque = {j: load[j] + value for j, value in with_load(p, load).items()}
    return {j: p.tape.name(f"T{j}", value) for j, value in torque.items()}


def loads(p: Plant, rigid: ByJoint) -> ByJoint:
    """Return the torque of the rigid body, as named steps if effects depend on it."""
    if not p.robot.loaded:
        return dict(rigid)
    return {j: p.tape.name(f"taur{j}", value) for j, value in rigid.items()}


def with_load(p: Plant, load: ByJoint) -> ByJoint:
    """Return the torque of friction, and of effects under a rigid-body load, by joint."""
    none = dict.fromkeys(load, sp.S.Zero)
    columns = weighted_effects(p, load)
    return combined([(sp.S.One, none), *columns, (sp.S.One, friction_torques(p))])


def weighted_effects(
    p: Plant, load: ByJoint | None, by: sp.Symbol | None = None
) -> list[tuple[sp.Expr, ByJoint]]:
    """Return the coefficients of effects with their columns by joint; see `effect_columns`."""
    columns = effect_columns(p.robot, p.tape, load, by)
    return [(p.value(name), column) for name, column in columns.items()]


def rigid_torques(p: Plant, qdd: ByJoint) -> ByJoint:
    """Return the torque of links and rotors at accelerations of the movable joints (default 0)."""
    torque = _body_torques(p, spread(p.robot, qdd, p.tape) if qdd else {})
    return with_rotors(p, torque, qdd)


def with_rotors(p: Plant, torque: ByJoint, rate: ByJoint) -> ByJoint:
    """Add the torques of rotors at accelerations, or their momenta at speeds."""
    columns = ((rate.get(k, sp.S.Zero), column) for k, column in rotors(p).items())
    return combined([(sp.S.One, torque), *columns])


def friction_torques(p: Plant, *, effects: bool = True) -> ByJoint:
    """Return the torque of friction, and of effects with columns if wanted, by joint."""
    columns = friction.friction_torque_columns(p.robot, p.tape)
    return combined((p.value(of.name), c) for of, c in columns if effects or of.prefix)


def joint_friction(p: Plant) -> ByJoint:
    """Return the torque of the declared friction of joints and couplings, by joint."""
    torque = friction_torques(p, effects=False)
    return {j: p.tape.name(f"T{j}", torque.get(j, sp.S.Zero)) for j in p.numbers}


def effect_torques(p: Plant) -> ByJoint:
    """Return the torque of the declared effects, by joint; load effects at this motion."""
    none = dict.fromkeys(p.numbers, sp.S.Zero)
    columns = weighted_effects(p, None)
    if p.robot.loaded:
        load = loads(p, rigid_torques(p, variables(p.robot, "qdd")))
        columns += weighted_effects(p, load)
    torque = combined([(sp.S.One, none), *columns])
    return {j: p.tape.name(f"T{j}", value) for j, value in torque.items()}


def gravity_torque(p: Plant) -> ByJoint:
    """Return the torque of gravity on the links."""
    return _body_torques(p.still(), {})


def wrenches(p: Plant, qdd: ByJoint) -> Wrenches:
    """Return the wrench that accelerates each link, at accelerations of all moving joints."""
    motion = accelerations(p.way, p.mounting, qdd, p.tape)
    return {j: body.wrench(motion[j], j, p.tape) for j, body in p.bodies.items()}


def _body_torques(p: Plant, qdd: ByJoint) -> ByJoint:
    return to_variables(p.robot, to_joints(p, wrenches(p, qdd), ""), "Tf", p.tape)


def summed_to_base(p: Plant, wrench: Wrenches, tag: str) -> Wrenches:
    """Sum the wrenches on links towards the base; return the wrench on each joint, in its frame.

    The wrench on a free base has the number 0.
    """
    total = dict(wrench)
    for step in reversed(p.way):
        j, a = step.joint.number, step.joint.antecedent
        if (a != 0 or p.robot.floating) and j in total:
            back = wrench_on_antecedent(total[j], step, f"b{tag}", p.tape)
            old = total.get(a, (ZERO, ZERO))
            total[a] = (
                named(plus(old[0], back[0]), f"F{tag}s{a}_{j}_", p.tape),
                named(plus(old[1], back[1]), f"N{tag}s{a}_{j}_", p.tape),
            )
    return total


def to_joints(p: Plant, wrench: Wrenches, tag: str) -> ByJoint:
    """Return the torque or force on each moving joint, from the wrenches on links.

    The force and moment on a free base come first.
    """
    total = summed_to_base(p, wrench, tag)
    return {
        number: acting(total.get(link, (ZERO, ZERO)), screw)
        for number, (link, screw) in axes(p.robot).items()
    }


def rotors(p: Plant) -> Rows:
    """Return the contribution of rotors to the mass matrix."""
    rows: Rows = {j: {} for j in axes(p.robot)}
    for j in p.numbers:
        rows[j][j] = p.value(f"{names.ROTOR}{j}")
    for c in p.robot.couplings:
        inertia = p.value(f"{names.COUPLING_INERTIA}{c.second}")
        share = friction.drive_shares(c, p.tape)
        for j, x in share.items():
            for k, y in share.items():
                add_to(rows[j], k, inertia * x * y)
    return rows


def mass_matrix(p: Plant) -> Rows:
    """Return M by rows and columns of joint numbers; entries of separate branches are absent.

    A free base has six rows and columns by the numbers of its equations.
    """
    bodies, rows = composites(p.way, p.bodies, p.tape), rotors(p)
    earlier: set[int] = set()
    for j, (link, screw) in axes(p.robot).items():
        earlier.add(j)
        momentum = bodies[link].momentum(screw)  # momentum at unit speed
        for k, value in to_joints(p, {link: momentum}, f"m{j}").items():
            if value != 0 and k in earlier:
                for a, b in {(j, k), (k, j)}:
                    add_to(rows[a], b, value)
    rows = {
        j: {k: p.tape.name(f"M{min(j, k)}_{max(j, k)}", v) for k, v in row.items()}
        for j, row in rows.items()
    }
    return congruent(p.robot, rows, "M", p.tape)


def coriolis(p: Plant) -> Rows:
    """Return C by rows and columns of joint numbers: C qd are the torques, M' - 2 C is skew."""
    rows: Rows = {j.number: {} for j in p.robot.moving}
    real = accelerations(p.way, AT_REST, {}, p.tape)
    after = {s.joint.number: path(p.robot, s.joint.number) for s in p.way}
    for j in rows:
        moved = tuple(s for s in p.way if j in after[s.joint.number])
        letters = Letters(f"E{j}_", f"e{j}_", f"l{j}_", f"l{j}_", "{}{}{}", f"l{j}p{{1}}_{{0}}")
        virtual = references(moved, real, AT_REST, {j: sp.S.One}, {}, p.tape, letters)
        wrench: Wrenches = {}
        for i, motion in virtual.items():
            tag = f"{i}v{j}"
            wrench[i] = p.bodies[i].virtual_wrench(motion, tag, p.tape, p.namer(tag))
        for k, value in to_joints(p, wrench, f"c{j}").items():
            rows[k][j] = p.tape.name(f"C{k}_{j}", value)
    return congruent(p.robot, rows, "C", p.tape)


def energies(p: Plant) -> list[sp.Expr]:
    """Return kinetic and potential energy of a robot in its base parameters, J.

    A robot with a free base has its kinetic energy only.
    """
    bases = [b for b in p.base.parameters if b.inertial]
    standard = [p.base.standard[b.index] for b in bases]
    columns = separate_columns(p.robot, standard, p.way, p.tape)
    return [
        p.tape.name(f"{letter}sum", sp.Add(*(x * c for x, c in zip(p.X, column, strict=False))))
        for letter, column in zip("TU", columns, strict=False)
    ]

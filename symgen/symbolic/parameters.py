"""The standard parameters of a robot, in the order of X, before any regrouping."""

from __future__ import annotations

from dataclasses import dataclass

from symgen import names
from symgen.robot.types import Joint, Robot


@dataclass(frozen=True)
class Parameter:
    """One standard parameter.

    Attributes:
        name: name as in tables: XX3, IA3, FS3, XXL.
        prefix: the name without its number.
        joint: number of its joint.
        unit: SI unit.
        inertial: whether it has an energy column (friction has a power column only).
        load: whether its torque depends on the rigid-body torque. It then has no column, and comes
            last.
    """

    name: str
    prefix: str
    joint: int
    unit: str
    inertial: bool
    load: bool = False


def standard_parameters(robot: Robot) -> tuple[Parameter, ...]:
    """Return the inertial parameters link by link, then friction joint by joint.

    Link 0 of a free base is the first.

    The rotor of a coupling follows the rotor of its second joint. The payload follows all links.
    The friction of couplings follows that of the joints. Effects come last: first those with
    columns, then those that depend on the rigid-body torque.
    """
    out: list[Parameter] = []

    def add(prefix: str, joint: Joint, inertial: bool = True, suffix: str | None = None) -> None:
        name = prefix + (str(joint.number) if suffix is None else suffix)
        unit = names.unit(prefix, joint.sigma)
        out.append(Parameter(name, prefix, joint.number, unit, inertial))

    driven = {c.second for c in robot.couplings}
    for joint in robot.bodies:
        for prefix in names.LINK:
            add(prefix, joint)
        if joint.rotor_inertia:
            add(names.ROTOR, joint)
        if joint.number in driven:
            add(names.COUPLING_INERTIA, joint)
    if robot.payload is not None:
        for prefix in names.LINK:
            add(prefix, robot.joint(robot.payload), suffix="L")
    for joint in robot.joints:
        for word in joint.friction:
            add(names.FRICTION[word], joint, inertial=False)
    for coupling in robot.couplings:
        for prefix in names.COUPLING_FRICTION:
            add(prefix, robot.joint(coupling.second), inertial=False)
    added = [
        Parameter(name, "", effect.joint, unit, inertial=False, load=effect.loads(name))
        for effect in robot.effects
        for name, unit in effect.linear
    ]
    return (*out, *sorted(added, key=lambda p: p.load))

"""Effects as a robot file declares them: from the library, or with a torque of the file."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import sympy as sp

from symgen.errors import RobotError, located, shortened
from symgen.robot import expressions
from symgen.robot.effect import OWN, Definition, Effect, definitions, numbered
from symgen.robot.tables import EffectTable


def of_library(
    definition: Definition,
    joint: int,
    sigma: int,
    constants: Mapping[str, sp.Expr],
    geometry: Mapping[str, sp.Expr] | None = None,
) -> Effect:
    """Return an effect of the library on one joint.

    Args:
        definition: an effect from `definitions`.
        joint: number of the joint.
        sigma: type of the joint.
        constants: name in the library -> value of each nonlinear constant.
        geometry: values of the named lengths that the constants may contain.

    Raises:
        RobotError: a constant is missing or unknown, or the torque has no finite value.
    """
    if set(constants) != set(definition.nonlinear):
        accepted = ", ".join(definition.nonlinear) or "none"
        raise RobotError(f"constants {', '.join(constants) or 'none'}; accepted: {accepted}")
    own = {f"{n}{joint}": constants[n] for n in definition.nonlinear}
    variables = [f"{n}{joint}" for n in (*OWN, *definition.linear)]
    torque = _torque(numbered(definition, joint), variables, own, geometry or {})
    return Effect(
        name=definition.name,
        joint=joint,
        linear=definition.coefficients(joint, sigma),
        nonlinear=tuple(own.items()),
        torque=torque,
    )


def _torque(
    text: str,
    variables: Collection[str],
    constants: Mapping[str, sp.Expr],
    geometry: Mapping[str, sp.Expr],
) -> sp.Expr:
    """Parse a torque. Its constants stay symbols, but their values must also be valid.

    Raises:
        RobotError: the torque is not an expression of the grammar.
    """
    functions = expressions.EFFECT_FUNCTIONS
    known = (*variables, *constants, *geometry)
    lengths = {sp.Symbol(name, real=True): value for name, value in geometry.items()}
    values = {**geometry, **{name: c.subs(lengths) for name, c in constants.items()}}
    with located("key 'torque'"):
        expr = expressions.parse(text, known, functions)
        expressions.check_powers(expr)
        # Refuse a torque that symgen could not read again from a file that it writes.
        expr = expressions.parse(expressions.text(expr), known, functions)
        expressions.check_powers(expressions.parse(text, known, functions, values))
    return expr


def of_file(
    name: str,
    joint: int,
    torque: str,
    linear: Mapping[str, str],
    nonlinear: Mapping[str, sp.Expr],
    variables: Collection[str],
    geometry: Mapping[str, sp.Expr],
) -> Effect:
    """Return an effect whose torque is defined in a robot file.

    Args:
        name: name in the file.
        joint: number of the joint on which the torque acts.
        torque: expression, linear in the names of `linear`.
        linear: coefficient -> unit.
        nonlinear: constant -> value.
        variables: q1, qd1, ... that may occur.
        geometry: named length -> value; these names may also occur.

    Raises:
        RobotError: the torque does not follow the grammar, or is not linear in its coefficients.
    """
    expr = _torque(torque, (*variables, *linear), nonlinear, geometry)
    symbols = [sp.Symbol(n, real=True) for n in linear]
    rest = expr.subs(dict.fromkeys(symbols, 0))
    slopes = [sp.diff(expr, s) for s in symbols]
    if not symbols or rest != 0 or any(d.has(*symbols) for d in slopes):
        raise RobotError(
            f"key 'torque': {shortened(torque)!r} is not a sum of the coefficients of "
            "'linear', each times an expression without them"
        )
    load = sp.Symbol(f"taur{joint}", real=True)
    if not all(_degree(d, load) in (0, 1) for d in slopes):
        raise RobotError(
            f"key 'torque': {shortened(torque)!r} is not of the form "
            f"a*taur{joint} + b*abs(taur{joint}) for a coefficient that taur{joint} goes with, "
            "with a and b of positions and speeds"
        )
    for key, declared in (("linear", linear), ("nonlinear", nonlinear)):
        for n in declared:
            if sp.Symbol(n, real=True) not in expr.free_symbols:
                raise RobotError(f"key {key!r}: {n} does not occur in the torque")
    return Effect(
        name=name,
        joint=joint,
        linear=tuple(linear.items()),
        nonlinear=tuple(nonlinear.items()),
        torque=expr,
        own=True,
    )


def _degree(expr: sp.Expr, load: sp.Symbol) -> sp.Expr | None:
    """Return k if the expression is abs(load)**k times its value at sign(load), else None.

    With k = 1, forward dynamics has a closed form.
    """
    if expr == load:
        return sp.S.One
    if not expr.has(load):
        return sp.S.Zero
    degrees = [_degree(part, load) for part in expr.args]
    if any(k is None for k in degrees):
        return None
    if expr.is_Add:
        return degrees[0] if len(set(degrees)) == 1 else None
    if expr.is_Mul:
        return sp.Add(*degrees)
    if expr.is_Pow and not expr.exp.has(load):
        return degrees[0] * expr.exp
    if expr.func is sp.Abs:
        return degrees[0]
    if expr.func is sp.sign or not any(degrees):
        return sp.S.Zero
    return None


def from_table(
    table: EffectTable,
    constants: Mapping[str, sp.Expr],
    movable: Mapping[int, int],
    geometry: Mapping[str, sp.Expr],
) -> list[Effect]:
    """Return the effects of one [[effect]] table, one for each joint.

    Args:
        table: the validated table: name, joints, torque, linear.
        constants: nonlinear constant -> exact value.
        movable: number of each movable joint -> its type.
        geometry: named length of the file -> value.

    Raises:
        RobotError: the message names the key.
    """
    known = definitions()
    if not table.torque:
        chosen = known.get(table.name)
        if chosen is None or not chosen.declarable:
            where = "" if chosen is None else f" ({_declared_by(chosen)})"
            accepted = ", ".join(n for n, d in known.items() if d.declarable)
            raise RobotError(
                f"key 'name': {shortened(table.name)!r} is no effect that needs no "
                f"'torque'{where}; accepted: {accepted}, or another name with a torque"
            )
        if table.linear:
            raise RobotError("key 'linear': an effect of the library has its own")
        return [of_library(chosen, j, movable[j], constants, geometry) for j in table.joints]
    if table.name in known:
        raise RobotError(f"key 'torque': {table.name} is an effect of the library and has its own")
    if len(table.joints) != 1:
        raise RobotError("key 'joints': an effect with a torque acts on one joint")
    j = table.joints[0]
    known_names = torque_variables(j, movable)
    return [of_file(table.name, j, table.torque, table.linear, constants, known_names, geometry)]


def torque_variables(joint: int, movable: Iterable[int]) -> list[str]:
    """Return the variables that a torque from the file may contain.

    Args:
        joint: number of the joint on which the torque acts.
        movable: numbers of all movable joints.
    """
    return [*(f"{letter}{k}" for letter in ("q", "qd") for k in movable), f"taur{joint}"]


def _declared_by(definition: Definition) -> str:
    if definition.native in ("coulomb", "viscous", "offset"):
        return f"a word of the joint's friction: {definition.native!r}"
    if definition.native:
        return {"rotor": "rotor_inertia of the joint"}.get(
            definition.native, f"a separate table: {definition.native}"
        )
    return f"kind {definition.kind}: a robot file does not declare it"

"""Read robots: robot.toml, other formats, generated packages, and the library."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import sympy as sp

from symgen import names
from symgen.errors import RobotError, SymgenWarning, located, message_of, shortened
from symgen.files import load_toml
from symgen.robot import expressions
from symgen.robot.declared_effects import from_table
from symgen.robot.effect import MAX_RANGES, Effect, Sought
from symgen.robot.exact_numbers import written_fraction
from symgen.robot.identifiers import MAX_NAME, is_robot_name
from symgen.robot.imported import FORMATS, Imported, read_text, robot_text
from symgen.robot.loop_check import require_closed
from symgen.robot.schema import TableReader, keys, require_keys
from symgen.robot.tables import (
    Contact,
    Coupling,
    Drive,
    EffectTable,
    Frame,
    GeometryName,
    Head,
    Limits,
    LogForm,
    Loop,
    Mount,
    PayloadTable,
    Sensor,
    Servo,
    word_check,
)
from symgen.robot.types import (
    GRAVITY_INPUT,
    MAX_JOINTS,
    MAX_RATIO,
    Joint,
    Robot,
    joint_variable,
)

#: The tables of a file.
_TABLES = (
    "robot", "geometry", "joint", "coupling", "payload", "limits", "drive", "controller", "log",
    "effect", "loop", "frame", "sensor", "base", "contact",
)  # fmt: skip
_GRAVITY = [0, 0, Decimal("-9.81")]  # m/s2, for files without gravity
_SIDE = Annotated[str, word_check("motor", "link")]
_FIXED = "a fixed joint (sigma 2) has none"
_FOLLOWS = (
    "a joint that follows others has none of its own; accepted: on the joints that it follows, or "
    "as [[coupling]]"
)
_SUM = "a sum of numbers times variables of movable joints, such as 'pi/2 + q7 - q2'"


def read_robot(source: Robot | str | Path) -> Robot:
    """Read a robot from a file, a generated package, or the built-in library.

    Args:
        source: path of a robot.toml, .urdf, .par or .xml file; path of a folder with a robot.toml;
            or name of a library robot. A Robot is returned unchanged.

    Returns:
        The robot, with exact geometry.

    Raises:
        RobotError: there is no such robot, or the file is not a valid one.
    """
    if isinstance(source, Robot):
        return source
    text, path = robot_text(source)
    if path.suffix.lower() not in FORMATS:
        return parse_robot(text, str(path))
    imported = parse_imported(text, path)
    for line in imported.assumed:
        warnings.warn(f"{path}: {line}", SymgenWarning, stacklevel=2)
    return imported.robot


def read_imported(path: str | Path, base: str | None = None) -> Imported:
    """Read a .urdf, a .par of SYMORO, or an .xml of MuJoCo.

    Args:
        path: path of the file.
        base: base of the robot, see `Robot`; None for a fixed one, unless the file has a free one.

    Raises:
        RobotError: the file cannot be read, or symgen cannot represent the robot.
    """
    accepted = f"accepted: a path to a file with the ending {' or '.join(FORMATS)}"
    if Path(path).suffix.lower() not in FORMATS:
        raise RobotError(f"{shortened(str(path)) or '(empty)'}: not such a file; {accepted}")
    return parse_imported(*read_text(path, accepted), base)


def parse_imported(text: str, path: Path, base: str | None = None) -> Imported:
    """Read the text of a file; its ending gives the format.

    Raises:
        RobotError: symgen cannot represent the robot.
    """
    name = FORMATS[path.suffix.lower()]
    module = import_module(f"symgen.robot.formats.{name}")
    found: Imported = getattr(module, f"import_{name}")(text, str(path), base)
    return found


def parse_robot(text: str, where: str = "robot.toml") -> Robot:
    """Read a robot from the text of a robot.toml.

    Args:
        text: the file's text.
        where: name of the file in error messages.

    Raises:
        RobotError: the text is not a valid robot; the message names the joint and the key.
    """
    with located(where):
        try:
            data = load_toml(text.removeprefix("\ufeff"), parse_float=_written)
        except (RecursionError, ValueError) as error:
            raise RobotError(f"not valid TOML: {message_of(error)}") from error
        return _robot(data, TableReader())


def _written(digits: str) -> Decimal:
    """Return a number of the file; a number beyond the range of decimals becomes infinite."""
    try:
        return Decimal(digits)
    except ArithmeticError:
        return Decimal("Infinity")


def _robot(data: Mapping[str, Any], reader: TableReader) -> Robot:
    """Build a robot from the content of a file."""
    require_keys(data, _TABLES, "file")
    if "robot" not in data:
        raise RobotError("robot: is missing; it must be given")
    lengths = reader.value(dict[GeometryName, sp.Expr], data.get("geometry", {}), "geometry")
    reader.geometry = {name: written_fraction(value) for name, value in lengths.items()}
    head = _head(data["robot"], reader)
    reader.floats = head.base == names.BASES[-1]
    joints = _joints(data, reader, reader.floats)
    sigma = {joint.number: joint.sigma for joint in joints if joint.movable}
    reader.joints, reader.movable = len(joints), tuple(sigma)
    effects, sought = _effects(_repeated(data, "effect"), sigma, reader)
    payload = _once(data, "payload", PayloadTable, reader)
    loops = enumerate(_repeated(data, "loop"), 1)
    robot = Robot(
        name=head.name,
        gravity=head.gravity,
        joints=joints,
        base=head.base,
        geometry=tuple(reader.geometry.items()),
        couplings=_couplings(_repeated(data, "coupling"), reader),
        payload=None if payload is None else payload.joint,
        limits=_once(data, "limits", Limits, reader),
        loops=tuple(reader.table(Loop, table, f"loop {k}") for k, table in loops),
        effects=tuple(effects),
        sought=tuple(sought),
        drive=_drive(data, reader),
        frames=_frames(_repeated(data, "frame"), reader),
        sensor=_once(data, "sensor", Sensor, reader),
        mount=_once(data, "base", Mount, reader),
        contacts=tuple(reader.table(Contact, t, "contact") for t in _repeated(data, "contact")),
        controller=_once(data, "controller", Servo, reader),
        log=_once(data, "log", LogForm, reader),
        exact=head.exact,
    )
    require_closed(robot)
    places = {"sensor": robot.sensor.frame} if robot.sensor is not None else {}
    places |= {f"contact {k}": contact.frame for k, contact in enumerate(robot.contacts, 1)}
    for place, frame in places.items():
        with located(f"{place}, key 'frame'"):
            robot.frame(frame)
    if robot.mount is not None and not robot.imu:
        raise RobotError("base: accepted: with base = 'imu' or 'floating' in [robot]")
    if any(contact.radius and contact.kind != "point" for contact in robot.contacts):
        raise RobotError("contact, key 'radius': accepted: with kind = 'point'")
    if robot.contacts and not robot.floating:
        raise RobotError("contact: accepted: with base = 'floating' in [robot]")
    return robot


def _once(data: Mapping[str, Any], key: str, kind: type[Any], reader: TableReader) -> Any:
    """Return a table of the file, or None if it has none."""
    return reader.table(kind, data[key], key) if key in data else None


def _repeated(data: Mapping[str, Any], key: str) -> list[Any]:
    """Return the tables of a repeated name."""
    tables = data.get(key, [])
    if not isinstance(tables, list):
        raise RobotError(f"{key}: is not a list; accepted: [[{key}]] for each table")
    return tables


def _head(table: Any, reader: TableReader) -> Head:
    require_keys(table, keys(Head), "robot")
    numbers = {"gravity": _GRAVITY} if table.get("gravity", "input") == "input" else {}
    head = reader.table(Head, table | numbers, "robot")
    if not is_robot_name(head.name):
        raise RobotError(
            f"robot, key 'name': {shortened(head.name)!r} is not accepted; accepted: a C "
            f"identifier of at most {MAX_NAME} characters that is no word and no header of C"
        )
    if table.get("gravity") != "input":
        return head
    if head.base != names.BASES[0]:
        raise RobotError(
            f"robot, key 'gravity': 'input' is not possible with base = {head.base!r}, whose "
            "specific force contains gravity; accepted: gravity where the base rests, three numbers"
        )
    return replace(head, gravity=GRAVITY_INPUT)


def _joints(data: Mapping[str, Any], reader: TableReader, floating: bool) -> tuple[Joint, ...]:
    if "joint" not in data and not floating:
        raise RobotError("joint: is missing; it must be given")
    tables = _repeated(data, "joint")
    least = 0 if floating else 1
    if not least <= len(tables) <= MAX_JOINTS:
        raise RobotError(f"joint: {len(tables)} entries; accepted: {least} to {MAX_JOINTS}")
    drive = data.get("drive")
    linked = isinstance(drive, dict) and drive.get("side") == "link"
    joints = [_joint(k, table, not linked, reader) for k, table in enumerate(tables, 1)]
    pairs = list(zip(joints, tables, strict=True))
    movable = {f"q{j.number}": j for j, table in pairs if j.movable and "follows" not in table}
    if not movable and not floating:
        raise RobotError("no joint is movable; accepted: at least one sigma of 0 or 1")
    for joint, table in pairs:
        if "follows" in table:
            place = f"joint {joint.number}, key 'follows'"
            with located(place):
                following = _following(joint, table["follows"], movable, reader)
            if joint.turns:
                reader.angle(following.offset, place)
            joints[joint.number - 1] = following
    return tuple(joints)


def _joint(number: int, table: Any, rotors: bool, reader: TableReader) -> Joint:
    """Return a joint, without its dependence on other joints."""
    place = f"joint {number}"
    require_keys(table, keys(Joint), place)
    fixed = table.get("sigma") == names.FIXED
    plain = fixed or "follows" in table
    for key in ("friction", "rotor_inertia", "coulomb_width"):
        if plain and table.get(key):
            raise RobotError(f"{place}, key {key!r}: {_FIXED if fixed else _FOLLOWS}")
    entries = {
        "sigma": names.REVOLUTE,
        "antecedent": number - 1,
        "friction": [] if plain else ["coulomb", "viscous"],
        "rotor_inertia": rotors and not plain,
        **table,
    }
    entries.pop("follows", None)
    joint = reader.table(Joint, entries, place, number=number)
    if not 0 <= joint.antecedent < number:
        raise RobotError(
            f"{place}, key 'antecedent': {joint.antecedent} is not an earlier joint; "
            f"accepted: 0 (the base) to {number - 1}"
        )
    if len(set(joint.friction)) != len(joint.friction):
        raise RobotError(f"{place}, key 'friction': a word stands twice")
    return replace(joint, friction=tuple(w for w in names.FRICTION if w in joint.friction))


def _following(
    joint: Joint, value: Any, movable: Mapping[str, Joint], reader: TableReader
) -> Joint:
    """Return a joint whose position is linear in the variables of other joints."""
    if joint.fixed:
        raise RobotError("a fixed joint (sigma 2) follows none")
    expr = sp.expand(reader.expression(value, (*reader.geometry, *movable)))
    joint = replace(joint, follows=expr)
    linear = sum((c * joint_variable(k) for k, c in joint.shares), joint.offset)
    if not joint.shares or sp.expand(linear - expr) != 0:
        raise RobotError(f"{shortened(str(value))!r}; accepted: {_SUM}")
    shares = sp.S.Zero
    for k, c in joint.shares:
        factor = reader.at_values(c)
        shares += factor * joint_variable(k)
        if {s.name for s in c.free_symbols} & set(movable):
            raise RobotError(f"not linear in q{k}; accepted: {_SUM}")
        if factor.is_zero:
            raise RobotError(f"the factor of q{k} is 0 at the file's values")
        if joint.turns:
            _require_turning(factor, movable[f"q{k}"], expressions.text(c))
    return replace(joint, follows=shares + joint.offset) if joint.turns else joint


def _require_turning(factor: sp.Expr, leader: Joint, written: str) -> None:
    """Refuse a factor of a revolute joint that is not a fraction, or too large."""
    place = f"the factor of q{leader.number} is {written}"
    if not (leader.turns and factor.is_Rational):
        raise RobotError(
            f"{place}; accepted for a revolute joint: fractions, of the variables of revolute "
            "joints"
        )
    if abs(factor) > MAX_RATIO:
        raise RobotError(
            f"{place}, which makes its rounding as much larger; accepted: at most {MAX_RATIO} in "
            "size"
        )


def _couplings(tables: Sequence[Any], reader: TableReader) -> tuple[Coupling, ...]:
    found: list[Coupling] = []
    for number, table in enumerate(tables, 1):
        place = f"coupling {number}"
        require_keys(table, keys(Coupling), place)
        coupling = reader.table(Coupling, {"ratio": 1, **table}, place)
        pair, second = set(coupling.joints), coupling.second
        if any(second == c.second or pair == set(c.joints) for c in found):
            raise RobotError(
                f"{place}, key 'joints': a second coupling of the same joints or number {second}"
            )
        if reader.at_values(coupling.ratio).is_zero:
            raise RobotError(f"{place}, key 'ratio': zero couples nothing")
        found.append(coupling)
    return tuple(found)


def _drive(data: Mapping[str, Any], reader: TableReader) -> Drive | None:
    """Return the drive; `side` sets the side of positions and torques."""
    if "drive" not in data:
        return None
    table = data["drive"]
    require_keys(table, (*keys(Drive), "side"), "drive")
    if not table:
        raise RobotError(
            "drive: declares nothing; accepted: ratio, torque_constant, supply or side"
        )
    sides = {"motor": "motor", "link": "joint"}
    side = reader.value(_SIDE, table.get("side", "motor"), "drive, key 'side'")
    entries = {
        "ratio": [1] * len(reader.movable),
        "position_side": sides[side],
        "torque_side": sides[side],
        **table,
    }
    entries.pop("side", None)
    for key in ("supply", "resistance", "limit"):  # one number is that of all joints
        if key in entries and not isinstance(entries[key], list):
            entries[key] = [entries[key]] * len(reader.movable)
    return reader.table(Drive, entries, "drive")


def _frames(tables: Sequence[Any], reader: TableReader) -> tuple[Frame, ...]:
    """Return the frames of a file.

    Raises:
        RobotError: two frames have the same name.
    """
    found: dict[str, Frame] = {}
    for number, table in enumerate(tables, 1):
        frame = reader.table(Frame, table, f"frame {number}")
        if frame.name in found:
            raise RobotError(
                f"frame {shortened(frame.name)!r}: the name stands twice; accepted: each name once"
            )
        found[frame.name] = frame
    return tuple(found.values())


def _effects(
    tables: Sequence[Any], sigma: Mapping[int, int], reader: TableReader
) -> tuple[list[Effect], list[Sought]]:
    """Return effects of the model, and effects to search."""
    found: list[Effect] = []
    sought: list[Sought] = []
    for number, entries in enumerate(tables, 1):
        place = f"effect {number}"
        table = reader.table(EffectTable, entries, place)
        with located(place):
            here, ranges = _effect(table, sigma, reader)
            earlier = (*found, *(s.effect for s in sought))
            # The same effect of the library with other constants is another effect: p = 2, p = 3.
            same = [e for e in earlier if e.name == table.name and e.constants == here[0].constants]
            others = [*same, *(e for e in earlier if e.own or here[0].own)]
            taken = {*reader.geometry, *(n for e in others for n in e.names)}
            for name in (n for e in here for n in e.names):
                if name in taken:
                    raise RobotError(f"{name} is declared twice")
                taken.add(name)
            if not ranges:
                found += here
                continue
            wanted = [Sought(e, ranges) for e in here]
            for name, joint in {s.key for s in sought} & {s.key for s in wanted}:
                raise RobotError(
                    f"a second {shortened(name)!r} to be searched on joint {joint}; accepted: "
                    "another name"
                )
            sought += wanted
    return found, sought


def _effect(
    table: EffectTable, sigma: Mapping[int, int], reader: TableReader
) -> tuple[list[Effect], tuple[tuple[str, sp.Expr, sp.Expr], ...]]:
    """Return the effects of a table, with the lower end of each range, and the ranges."""
    ranges = tuple((name, *x) for name, x in table.nonlinear.items() if isinstance(x, tuple))
    with located("key 'nonlinear'"):
        for _, low, high in ranges:
            if reader.at_values(low - high) >= 0:
                ends = ", ".join(shortened(expressions.text(end)) for end in (low, high))
                raise RobotError(
                    f"the range [{ends}] is empty; accepted: [low, high], low below high"
                )
        if len(ranges) > MAX_RANGES:
            raise RobotError(
                f"{len(ranges)} ranges; accepted: at most {MAX_RANGES}, and numbers for the others"
            )
    values = [x if isinstance(x, tuple) else (x,) for x in table.nonlinear.values()]
    lowest, *_ = [  # the torque must be valid at all corners of the ranges
        from_table(table, dict(zip(table.nonlinear, corner, strict=True)), sigma, reader.geometry)
        for corner in itertools.product(*values)
    ]
    return lowest, ranges

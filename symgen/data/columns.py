"""Match the column names of a file, given by the user or by a recorder, to those of a log.

Names of recorders contain a joint and a word for the quantity: `panda_joint1_position`, `pos_1`,
`/joint_states/elbow/effort`, `tau_0 [Nm]`. The joint is a number or a name in the robot file.
Columns that differ only in the joint form a pattern, `*_position`. symgen matches a role that has
exactly one pattern with all joints, and reports it. It refuses a role with two: it does not guess.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from shlex import quote

from symgen.data.raw import NUMBERED, Wanted, refuse
from symgen.data.units import QUANTITIES, TIMES, split_unit, unit_of
from symgen.errors import LogError, plain
from symgen.files import load_toml

#: Start of the command that fixes joints; the command line inserts the file.
IMPORT = "symgen import FILE "
_ACCEPTED = "ours=theirs separated by commas, such as t=time,q1=shoulder_pos, or a .toml file"
_WORDS = {
    "q": {"q", "pos", "position", "positions", "angle"},
    "qd": {"qd", "dq", "vel", "velocity", "velocities", "speed"},
    "tau": {"tau", "torque", "torques", "effort", "efforts", "eff"},
    "i": {"i", "current", "currents"},
}
_SECONDS = {"s", "sec", "secs", "seconds", "header"}
#: Words for commanded quantities, which were not measured.
_ASKED = set("d des desired target command commanded cmd reference ref goal setpoint error".split())
_FOREIGN = set("deg degree degrees rpm ms us ns mm mnm ma percent".split())  # inside a name
_TOKEN = re.compile(r"[A-Za-z]+|[0-9]+")
#: Position of a joint in the robot -> column, for one pattern.
Pattern = dict[int, str]


def columns_from(text: str) -> dict[str, str]:
    """Return log column -> column of the file, for `Reading.columns`.

    Args:
        text: "t=time,q1=shoulder_pos", or the path of a TOML file with a table [columns].

    Raises:
        LogError: the text or the file has another form.
    """
    if text.endswith(".toml"):
        return _from_file(Path(text))
    found: dict[str, str] = {}
    for pair in text.split(","):
        ours, sign, theirs = (part.strip() for part in pair.partition("="))
        if not (ours and sign and theirs):
            raise LogError(f"--columns: {pair[:40]!r}; accepted: {_ACCEPTED}")
        if ours in found:
            raise LogError(f"--columns: {ours} is given twice; accepted: {_ACCEPTED}")
        found[ours] = theirs
    return found


def units_from(text: str) -> dict[str, str]:
    """Return column or role -> unit, for `Reading.unit`, from "deg" or "q=deg,tau2=mNm"."""
    pairs = [part.strip().partition("=") for part in text.split(",") if part.strip()]
    return {ours.strip() if sign else "": (unit or ours).strip() for ours, sign, unit in pairs}


def _from_file(path: Path) -> dict[str, str]:
    accepted = 'accepted: a table [columns] of texts, such as q1 = "shoulder_pos"'
    try:
        data = load_toml(path.read_text("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        raise LogError(f"--columns {path}: {error}; {accepted}") from error
    table = data.get("columns")
    if set(data) != {"columns"} or not isinstance(table, dict):
        raise LogError(f"--columns {path}: holds {', '.join(data) or 'nothing'}; {accepted}")
    for ours, theirs in table.items():
        if not isinstance(theirs, str):
            raise LogError(f"--columns {path}: {ours} is not a text; {accepted}")
    return dict(table)


def another_number(joints: int, n: int, names: Sequence[str] = ()) -> tuple[str, str]:
    """Return error text and accepted input for a log with the wrong number of joints.

    Args:
        joints: number of joints in the log.
        n: number of movable joints of the robot.
        names: names of the movable joints, in order.
    """
    count = f"{joints} joint{'s' if joints > 1 else ''}"
    what, accepted = f"the log has {count}, the robot has {n}", "one q and tau per movable joint"
    beyond = [plain(name) for name in names[joints:]]
    if not beyond or not all(beyond):
        return what, accepted
    return f"{what}: no column for {', '.join(beyond)}", f"{accepted}, or {held_still(beyond)}"


def held_still(joints: Sequence[str]) -> str:
    """Return how joints without columns are held still."""
    return f"joints without columns held still: {fixing(map(plain, joints))}"


def fixing(joints: Iterable[str]) -> str:
    """Return the command that fixes joints of an imported robot, NAME or NAME=VALUE each."""
    fixes = " ".join(f"--fix {quote(joint)}" for joint in joints)
    return f"{IMPORT}{fixes} --into robot.toml"


def matched(
    file: str,
    names: Sequence[str],
    patterns: Mapping[str, str],
    wanted: Wanted,
) -> tuple[list[str], tuple[str, ...]]:
    """Rename columns of a recorder to those of a log; columns with log names stay.

    Args:
        file: name of the file.
        names: its column names.
        patterns: patterns from the user, {"q": "*_position"}, where * is the joint.
        wanted: the robot and the columns to read.

    Returns:
        The new names, and one line that reports the matches, or none.

    Raises:
        LogError: a role has several patterns, or lacks columns of joints.
    """
    own = {match[1] for name in names if (match := NUMBERED.fullmatch(name))}
    if not patterns and "t" in names and "q" in own and own & {"tau", "i", "qr"}:
        return list(names), ()  # log names; other columns are ignored
    ours: dict[str, str] = {}
    said = []
    if "t" not in names and (time := _time(names)) is not None:
        ours[time] = "t"
        said.append(f"t = {time}")
    of = ""
    for role in ("q", "qd", "tau", "i"):
        found_torque = "tau" in own or "tau1" in ours.values()
        if role in own or (role == "i" and found_torque and not wanted.currents):
            continue
        if role in patterns:
            pattern, columns = patterns[role], _asked(names, role, patterns[role], wanted)
        else:
            pattern, columns = _found(names, role, wanted)
        if columns:
            first, last = min(columns), max(columns)
            ours |= {column: f"{role}{place - first + 1}" for place, column in columns.items()}
            said.append(f"{role} = {pattern}")
            if "*" in pattern:
                joints = wanted.joints if first == 0 and last < len(wanted.joints) else ()
                named = joints and columns[0] == pattern.replace("*", joints[0])
                of = f"; * = {', '.join(joints) if named else f'{first} to {last}'}"
    line = f"{file}: columns by name: {', '.join(said)}{of}"
    return [ours.get(name, name) for name in names], (line,) if said else ()


def _time(names: Sequence[str]) -> str | None:
    """Return the only time column, or None; one in s is preferred."""
    found = []
    for name in names:
        tokens = {token.lower() for token in _TOKEN.findall(split_unit(name)[0])}
        if len(tokens & TIMES) == 1 and tokens <= TIMES | _SECONDS:
            found.append(name)
    found = _in_si(found, ("time",))
    if len(found) > 1:
        what = f"{' and '.join(map(_shown, found[:3]))} are times"
        refuse(what, f'one column t, as by --columns "t={_shown(found[0])}"')
    return found[0] if found else None


def _in_si(names: list[str], quantities: Sequence[str]) -> list[str]:
    """Return the names whose header has no foreign unit, or all if there are none."""
    units = [(name, split_unit(name)[1]) for name in names]
    own = [
        name
        for name, text in units
        if not text or any((u := unit_of(text, q)) and not u.foreign for q in quantities)
    ]
    return own or names


def _shown(name: str) -> str:
    return plain(name[:80])


def _role(rest: str) -> str | None:
    """Return the quantity from a column name without its joint; None if unclear."""
    tokens = {token.lower() for token in _TOKEN.findall(split_unit(rest.strip(" _"))[0])}
    if tokens & (_ASKED | _FOREIGN):
        return None
    found = [role for role, words in _WORDS.items() if tokens & words]
    return found[0] if len(found) == 1 else None


def _found(names: Sequence[str], role: str, wanted: Wanted) -> tuple[str, Pattern]:
    """Return the only pattern of a role with its columns by joint, if there is one."""
    joints, n = wanted.joints, wanted.n
    named = _by_name(names, role, joints)
    whole = {p: c for p, c in named.items() if len(c) == len(joints)}
    if named and not whole:
        pattern, columns = max(named.items(), key=lambda pair: len(pair[1]))
        missing = [joints[k] for k in range(len(joints)) if k not in columns]
        what = f"{_shown(pattern)} has no column for {', '.join(missing)}"
        refuse(what, f"columns of all joints, or {held_still(missing)}")
    if not whole:
        runs = _by_number(names, role, n)
        whole = {p: c for p, c in runs.items() if len(c) == n} or runs
    preferred = _in_si(list(whole), QUANTITIES[role])
    whole = {p: c for p, c in whole.items() if p in preferred}
    if len(whole) > 1:
        first, second, *_ = map(_shown, whole)
        what = f"{role} may be {first} or {second}, with * for the joint"
        refuse(what, f'--columns "{role}={first}", or another')
    return next(iter(whole.items()), ("", {}))


def _by_name(names: Sequence[str], role: str, joints: Sequence[str]) -> dict[str, Pattern]:
    """Return the patterns of a role whose columns contain names of the robot's joints."""
    out: dict[str, Pattern] = {}
    longest = sorted((j for j in joints if j), key=len, reverse=True)
    if not longest:
        return out
    any_joint = re.compile(rf"(?<![A-Za-z0-9])({'|'.join(map(re.escape, longest))})(?![A-Za-z0-9])")
    place = {joint: k for k, joint in enumerate(joints)}
    for name in names:
        match = any_joint.search(name)
        if match is None:
            continue
        before, after = name[: match.start()], name[match.end() :]
        if _role(f"{before} {after}") == role:
            out.setdefault(f"{before}*{after}", {})[place[match[1]]] = name
    return out


def _by_number(names: Sequence[str], role: str, n: int | None) -> dict[str, Pattern]:
    """Return the patterns whose numbers run from 0 or from 1 without gaps.

    For a robot with one joint, a column needs no number.
    """
    out: dict[str, Pattern] = {}
    for name in names:
        if _role(name) != role:
            continue
        if n == 1:
            out[name] = {0: name}
            continue
        for match in re.finditer("[0-9]+", name):
            if len(match[0]) < 4:
                pattern = f"{name[: match.start()]}*{name[match.end() :]}"
                out.setdefault(pattern, {})[int(match[0])] = name
    return {
        pattern: columns
        for pattern, columns in out.items()
        if sorted(columns) in (list(range(len(columns))), list(range(1, len(columns) + 1)))
        and (len(columns) > 1 or n in (None, 1))
    }


def _asked(names: Sequence[str], role: str, pattern: str, wanted: Wanted) -> Pattern:
    """Return the columns of a pattern from the user."""
    joints = wanted.joints
    count = wanted.n or sum(pattern.replace("*", str(k)) in names for k in range(1000))
    keys = [dict(enumerate(joints))] if joints and all(joints) else []
    keys += [{k: str(k) for k in range(first, first + count)} for first in (1, 0)]
    tried = [{k: pattern.replace("*", key) for k, key in own.items()} for own in keys]
    columns = next((c for c in tried if c and set(names).issuperset(c.values())), None)
    if columns is None:
        what = f"--columns {role}={pattern}: no such column of every joint"
        shown = ", ".join(name for name in names if name)[:300]
        refuse(what, f"a pattern with * for the joint's name or number, of {shown}")
    return columns

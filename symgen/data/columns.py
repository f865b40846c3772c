"""Match the column names of a file to those of a log. The names come from the user or a recorder.

Names of recorders contain a joint and a word for the quantity: `panda_joint1_position`, `pos_1`,
`/joint_states/elbow/effort`, `tau_0 [Nm]`. The joint is a number or a name in the robot file.
Columns that differ only in the joint form a pattern, `*_position`. symgen matches a role that has
exactly one pattern with all joints, and reports it. It refuses a role with two: it does not guess.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import NoReturn

from symgen.data.csv_text import NO_HEADER, CsvForm, texts_of
from symgen.data.raw import (
    BESIDE,
    CHANNELS,
    COLUMNS,
    DRIVING,
    FRAMED,
    NAMED,
    NUMBERED,
    ROLES,
    VECTORS,
    Wanted,
    listed,
    refuse,
    roles_with_unit,
    unused_torques,
)
from symgen.data.units import TIMES, in_si, is_sum, rest_of, split_unit, unit_of
from symgen.errors import plain
from symgen.names import WRENCH_ENDS

#: Start of the command that fixes joints; the command line inserts the file name.
IMPORT = "symgen import FILE "
_SECONDS = {"s", "sec", "secs", "seconds", "header"}
#: Words for a duty in names of columns that the user takes for torques.
_DUTIES = {"duty", "pwm", "load"}
#: Words for commanded quantities, which were not measured.
_COMMANDS = set(
    "d des desired target command commanded cmd reference ref goal setpoint error action".split()
)
# words of foreign units inside a name
_FOREIGN = set("deg degree degrees rpm ms us ns mm mnm ma percent".split())
#: Words of a name, also inside MotorTorque.
_TOKEN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+")
#: Role -> joint (from 0) -> place of its column in the file.
Groups = dict[str, dict[int, int]]
# column name of an array in a message
_INDEXED = re.compile(r"(|.*[^A-Za-z])([A-Za-z]+)[\W_]*([0-9]+)\W*")
# column of a joint's name, or of a list of names
_NAMES = re.compile(r"(|.*[^A-Za-z])name(?:[\W_]*([0-9]+)\W*)?")
_PATTERN = {"t": "t=NAME", "q1": "q=*_NAME", "tau1": "tau=*_NAME"}
#: Position of a joint in the robot -> name of its column, for one pattern.
Pattern = dict[int, str]


def another_number(joints: int, wanted: Wanted) -> tuple[str, str]:
    """Return error text and accepted input for a log with the wrong number of joints.

    Args:
        joints: number of joints in the log.
        wanted: the robot.
    """
    count = f"{joints} joint{'s' if joints > 1 else ''}"
    what = f"the log has {count}, the robot has {wanted.n}"
    accepted = "one q and tau per movable joint"
    beyond = [plain(name) for name in wanted.joints[joints:]]
    if beyond and all(beyond):
        accepted = f"{accepted}, or {how_to_hold(beyond, wanted)}"
        what = f"{what}: no column for {', '.join(beyond)}"
    return what, accepted


def how_to_hold(joints: Sequence[str], wanted: Wanted) -> str:
    """Return how to hold joints without columns still."""
    fixes = dict(zip(wanted.joints, wanted.fixes, strict=False))
    command = fixing(plain(fixes.get(joint, joint)) for joint in joints)
    return f"joints without columns held still: sigma = 2 in robot.toml; URDF or MJCF: {command}"


def fixing(joints: Iterable[str]) -> str:
    """Return the command that fixes joints of an imported robot, NAME or NAME=VALUE each."""
    fixes = " ".join(f"--fix {quote(joint)}" for joint in joints)
    return f"{IMPORT}{fixes} --into robot.toml"


def joints_of_file(wanted: Wanted, present: Sequence[str]) -> list[str]:
    """Return the names of the robot's joints in a file that names joints.

    Args:
        wanted: the robot, and names from the user in its order.
        present: names in the file.

    Raises:
        LogError: the file lacks a joint, or the robot has no names.
    """
    from_user = wanted.reading.joints
    joints = list(from_user or wanted.joints or [""])
    missing = [name for name in joints if name not in present]
    if missing:
        how = "--joints with the names in the robot's order, separated by commas"
        if not from_user and len(missing) < len(joints):
            how = f"{how}, or {how_to_hold(missing, wanted)}"
        shown = ", ".join(map(plain, present[:24])) or "none"
        refuse(f"the robot's joint {missing[0]!r} is not among {shown}", how)
    return joints


def with_joints(path: Path, form: CsvForm, wanted: Wanted) -> list[str]:
    """Return the header, with the joint that text columns name in its columns: field.name0 = elbow.

    Raises:
        LogError: the names change, or are not those of the robot's joints.
    """
    header = list(form.header)
    named: dict[tuple[str, int], str] = {}  # prefix and number of a column -> joint
    for k, name in enumerate(header):
        match = _NAMES.fullmatch(name)
        cell = "".join(form.first[0][k : k + 1])
        if match and (match[2] or cell.startswith(("[", "("))):
            text, *others = texts_of(path, form, k)
            if others:
                what = f"the joints in column {name} change: {text}, {others[0]}"
                refuse(what, "one order of joints in a file")
            for j, joint in enumerate(text.strip("[]()").split(",")):
                number = int(match[2] or j)
                named[match[1], number] = joint.strip(" '\"")
    for k, name in enumerate(header):
        match = _INDEXED.fullmatch(name)
        owner = match and named.get((match[1], int(match[3])))
        if match and owner:
            header[k] = f"{match[1]}{match[2]}.{owner}"
    if named:
        joints_of_file(wanted, [*named.values()])
    return header


def assigned(stored: Sequence[str], file: str, wanted: Wanted) -> tuple[Groups, tuple[str, ...]]:
    """Assign roles to the columns of a table.

    Returns:
        Places of the columns by role and joint, and notes on automatic matches.

    Raises:
        LogError: a column is missing, or occurs twice.
    """
    names = [name.strip() for name in stored]
    wanted = replace(wanted, joints=wanted.reading.joints or wanted.joints)
    texts = _without_units(names)
    framed = wanted.framed
    numbered = [(_place(text) or framed.get(text), name) for text, name in texts.items()]
    patterns, matches = {}, []
    for ours, theirs in wanted.reading.pairs.items():
        if "*" in theirs and ours != "t":
            patterns[ours] = theirs
            continue
        place = _place(ours) or framed.get(ours)
        if place is None:
            refuse(f"--columns {ours}={theirs}: a table has one column a joint", COLUMNS)
        if theirs not in names:
            refuse(f"there is no column {theirs!r} (--columns {ours})", listed(names))
        numbered.append((place, theirs))
        matches.append(f"{ours} = {theirs}")
    columns: dict[str, Pattern] = {}
    for place, name in numbered:
        if place:
            columns.setdefault(place[0], {})[place[1]] = name
    from_zero = [role for role in ROLES if 0 in columns.get(role, ())]
    for role, have in columns.items():
        first = 0 if role in from_zero else 1
        columns[role] = {number - first: name for number, name in have.items()}
    if patterns or not (columns.keys() >= {"t", "q"} and columns.keys() & DRIVING):
        matches += _matched(names, texts, columns, patterns, wanted)
    _require_complete(names, columns, wanted)
    used = {name for have in columns.values() for name in have.values()}
    notes = []
    if matches:
        known = used | {*map(rest_of, names)}
        spare = [name for name in names if name and name not in known]
        unused = f"; not used: {listed(spare)}" if spare else ""
        notes.append(f"columns by name: {', '.join(matches)}{unused}")
    if from_zero:
        notes.append(f"{', '.join(from_zero)} count joints from 0")
    for name in used:
        if (count := names.count(name)) > 1:
            what = f"the column {_shown(name)} occurs {count} times"
            refuse(what, f"each column once, or {NO_HEADER}")
    _require_torques([*columns.get("tau", {}).values()], wanted)
    groups: Groups = {}
    for role, have in columns.items():
        groups[role] = {j: names.index(name) for j, name in have.items()}
    return groups, tuple(f"{file}: {note}" for note in notes)


def _require_torques(names: Sequence[str], wanted: Wanted) -> None:
    """Refuse torques with the name of a duty, or of the load of a servo, and without a unit."""
    no_torque = _DUTIES & _tokens(" ".join(names))
    if no_torque and "tau" not in roles_with_unit(wanted.reading) and not split_unit(names[0])[1]:
        what = f"{_shown(names[0])} is the duty of a servo by its name, and has no unit"
        refuse(what, "--columns u=.. with --unit u=%, or --unit tau=Nm")


def _place(column: str) -> tuple[str, int] | None:
    """Return role and number of a log column: ("q", 1) for q1; None for another name."""
    if column in NAMED:
        return NAMED[column]
    match = NUMBERED.fullmatch(column)
    return match and (match[1], int(match[2]))


def _without_units(names: Sequence[str]) -> dict[str, str]:
    """Return the columns by their names without units; of several alike, the one in SI units."""
    alike: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        alike.setdefault(split_unit(name)[0], []).append(name)
    out = {}
    for text, several in alike.items():
        preferred = [name for name in several if in_si(split_unit(name)[1])]
        if len(several) == 1 or len(preferred) == 1:
            out[text] = (preferred or several)[0]
        else:
            out |= {name: name for name in several}
    return out


def _require_complete(names: Sequence[str], columns: dict[str, Pattern], wanted: Wanted) -> None:
    """Refuse columns that are no log, and drop those that are not read.

    Args:
        names: columns of the file.
        columns: those with a role, by joint.
        wanted: the robot and the columns to read.
    """
    if "tau" in columns and len(columns.get("i", ())) != len(columns.get("q", ())):
        columns.pop("i", None)
    for role in unused_torques(columns, wanted):
        del columns[role]
    for role, vector in VECTORS.items():
        have = columns.get(role, {})
        lacking = [name for k, name in enumerate(vector) if k not in have]
        if lacking and wanted.reading.wrench and role == "wrench":
            how = f"columns {', '.join(vector)}, or --columns {lacking[0]}=NAME"
            refuse(f"there is no column {lacking[0]} among {listed(names)}", how)
        if lacking:
            columns.pop(role, None)
    require_wrenches(columns.get("forces", {}), wanted)
    if "t" not in columns:
        _refuse_without("t", names, columns, wanted)
    if wanted.n == 0:
        return
    if "q" not in columns:
        _refuse_without("q1", names, columns, wanted)
    if not columns.keys() & DRIVING:
        _refuse_without("tau1", names, columns, wanted)
    for role, have in columns.items():
        if role in FRAMED:
            continue
        if role in BESIDE:  # only some joints may have it
            columns[role] = {j: name for j, name in have.items() if 0 <= j < len(columns["q"])}
        elif sorted(have) != [*range(len(have))]:
            only = ", ".join(f"{role}{j + 1}" for j in sorted(have))
            what = f"of the columns {role}1, {role}2, .. there are only {only}"
            refuse(what, f"{COLUMNS} of all joints")


def require_wrenches(have: Collection[int], wanted: Wanted) -> None:
    """Refuse a frame with some of the six columns of its wrench only."""
    for k, frame in enumerate(wanted.frames):
        of_frame = range(len(WRENCH_ENDS) * k, len(WRENCH_ENDS) * (k + 1))
        lacking = [end for j, end in zip(of_frame, WRENCH_ENDS, strict=True) if j not in have]
        if 0 < len(lacking) < len(WRENCH_ENDS):
            every = ", ".join(f"{frame}.{end}" for end in WRENCH_ENDS)
            refuse(f"there is no column {frame}.{lacking[0]}", f"none of a frame, or {every}")


def _refuse_without(
    column: str, names: Sequence[str], columns: Mapping[str, Pattern], wanted: Wanted
) -> NoReturn:
    """Refuse a file without a column of a log, with the option that the header suggests."""
    missing = [role for role in ("q", "tau") if role not in columns]
    pairs = suggested(names, missing, wanted) or f'--columns "{_PATTERN[column]}"'
    how = f"{COLUMNS}, or {pairs}"
    used = [name for have in columns.values() for name in have.values()]
    others = [name for name in names if name and name not in used]
    if column == "t" and len(others) == 1 and not {",", "="} & {*others[0]}:
        unit = split_unit(others[0], time=True)[1]
        unsure = "" if unit else ", if it is a time; poses need the motion between them"
        how = f'--columns "t={plain(others[0])}"{unsure}'
    refuse(f"there is no column {column} among {listed(names)}", how)


def _matched(
    names: Sequence[str],
    texts: Mapping[str, str],
    columns: dict[str, Pattern],
    patterns: Mapping[str, str],
    wanted: Wanted,
) -> list[str]:
    """Add columns of a recorder to those with a role; return the matches as texts.

    Args:
        names: columns of the file.
        texts: the columns by their names without units.
        columns: those with a role, by joint.
        patterns: patterns from the user, {"q": "*_position"}, where * is the joint. It is one of
            the joints without a column from the user.
        wanted: the robot and the columns to read.

    Raises:
        LogError: a role has several patterns, or lacks columns of joints.
    """
    matches = []
    if "t" not in columns and (time := _time(names)) is not None:
        columns["t"] = {0: time}
        matches.append(f"t = {time}")
    star = ""
    for role, channel in CHANNELS.items():
        has_torque = "tau" in columns and not wanted.currents
        needless = role in columns or (role == "i" and has_torque)
        if role not in patterns and (needless or not channel.words or wanted.n == 0):
            continue
        have = columns.get(role, {})
        of_user = {j: name for j, name in have.items() if f"{role}{j + 1}" in wanted.reading.pairs}
        free = [j for j in range(len(names)) if j not in of_user]
        rest = wanted
        if of_user:
            joints = [wanted.joints[j] for j in free if j < len(wanted.joints)]
            n = wanted.n and wanted.n - len(of_user)
            rest = replace(wanted, n=n, joints=joints, sigma=(), fixed=())
        if pattern := patterns.get(role, ""):
            found = _user_pattern(names, texts, role, pattern, rest)
        else:
            pattern, found = _only_pattern(texts, role, rest)
        if found:
            first, last = min(found), max(found)
            columns[role] = of_user | {free[k - first]: name for k, name in found.items()}
            matches.append(f"{role} = {pattern}")
            if "*" in pattern:
                star = f"{first} to {last}"
                if rest.joints:
                    robot = ", ".join(rest.joints)
                    named = short_name(rest.joints[0]) in found[first]
                    star = robot if named else f"{star} for {robot}"
    if star:
        matches[-1] += f"; * = {star}"
    return matches


def _time(names: Sequence[str]) -> str | None:
    """Return the only time column, or None; one in s is preferred."""
    sums = [*filter(is_sum, names)]
    parts = {*sums, *map(rest_of, sums)}
    times = []
    for name in names:
        tokens = _tokens(split_unit(name)[0])
        if name not in parts and len(tokens & TIMES) == 1 and tokens <= TIMES | _SECONDS:
            times.append(name)
    seconds = [name for name in times if in_si(split_unit(name)[1])]
    times = [*(seconds or times), *sums]
    if len(times) > 1:
        what = f"{' and '.join(map(_shown, times[:3]))} are times"
        refuse(what, f'one column t, as by --columns "t={_shown(times[0])}"')
    return times[0] if times else None


def _shown(name: str) -> str:
    return plain(name[:80])


def _role(pattern: str) -> str | None:
    """Return the quantity from a column name with * for its joint; None if unclear."""
    text = pattern.replace("*", "1").strip(" _")
    tokens = _tokens(split_unit(text)[0])
    if tokens & (_COMMANDS | _FOREIGN):
        return None
    roles = [
        role for role, channel in CHANNELS.items() if tokens.intersection(channel.words.split())
    ]
    return roles[0] if len(roles) == 1 else None


def _only_pattern(texts: Mapping[str, str], role: str, wanted: Wanted) -> tuple[str, Pattern]:
    """Return the only pattern of a role with its columns by joint, or an empty one."""
    n = wanted.n
    named = _of_role(by_name(texts, wanted.joints), role)
    complete = _with_columns(named, len(wanted.joints))
    if named and not complete:
        _refuse_missing(texts, role, named, wanted)
    if not complete:
        runs = _of_role(by_number(texts, n), role)
        complete = _with_columns(runs, n) or runs
        if role == "qd" and not any(wanted.kept(len(columns)) for columns in complete.values()):
            return "", {}  # speeds of some joints are no speeds
    if not complete:
        return "", {}
    only, *others = complete
    columns = complete[only]
    if others:
        first, second = _shown(only), _shown(others[0])
        what = f"{role} may be {first} or {second}, with * for the joint"
        refuse(what, f'--columns "{role}={first}", or another')
    if len(columns) < (n or 0) and not named:
        what = f"{_shown(only)} has {len(columns)} columns for {n} joints"
        refuse(what, f'--columns "{role}1=NAME,{role}={_shown(only)}", or other pairs')
    return only, {k: texts[text] for k, text in columns.items()}


def _of_role(patterns: Mapping[str, Pattern], role: str) -> dict[str, Pattern]:
    return {pattern: patterns[pattern] for pattern in patterns if _role(pattern) == role}


def _with_columns(patterns: Mapping[str, Pattern], count: int | None) -> dict[str, Pattern]:
    return {pattern: columns for pattern, columns in patterns.items() if len(columns) == count}


def _refuse_missing(
    texts: Mapping[str, str], role: str, patterns: Mapping[str, Pattern], wanted: Wanted
) -> NoReturn:
    """Refuse patterns that lack columns of joints, with the columns that may be theirs."""
    pattern, columns = max(patterns.items(), key=lambda pair: len(pair[1]))
    missing = [k for k in range(len(wanted.joints)) if k not in columns]
    used = {*columns.values()}
    spare = [name for text, name in texts.items() if text not in used and _may_be(name, role)]
    accepted = ["columns of all joints"]
    if len(spare) >= len(missing):
        pairs = ",".join(f"{role}{k + 1}=COLUMN" for k in missing)
        option = f'--columns "{role}={_shown(pattern)},{pairs}"'
        accepted.append(f"{option} with COLUMN one of {listed(spare)}")
    lacking = [wanted.joints[k] for k in missing]
    if role == "q":
        accepted.append(how_to_hold(lacking, wanted))
    what = f"{_shown(pattern)} has no column for {', '.join(lacking)}"
    refuse(what, ", or ".join(accepted))


def _may_be(name: str, role: str) -> bool:
    """Return whether a column may be of a role: it has no other name, and no unit of another."""
    text, unit = split_unit(name)
    if not name or _place(text) or _tokens(text) & (TIMES | _COMMANDS):
        return False
    if unit and not any(unit_of(unit, quantity) for quantity in CHANNELS[role].quantities):
        return False
    return _role(name) in (None, role)


def suggested(names: Sequence[str], roles: Sequence[str], wanted: Wanted) -> str:
    """Return the option --columns that the header suggests for some roles, or ""."""
    patterns = by_name(names, wanted.joints) | by_number(names, wanted.n)
    measured = [pattern for pattern in patterns if not _tokens(pattern) & _COMMANDS]
    long_enough = [p for p in measured if len(patterns[p]) >= (wanted.n or 1)]
    unclear = [p for p in long_enough if _role(p) is None]
    pairs = []
    for role in roles:
        every = CHANNELS[role].words.split()
        words = [word for word in every if len(word) > 2]
        fits = [p for p in measured if any(word in p.lower() for word in words)]
        for pattern in [*fits, *unclear][:1]:
            text, _ = split_unit(pattern)
            pairs.append(f"{role}={_shown(text)}")
    return f'--columns "{",".join(pairs)}"' if pairs else ""


def _tokens(name: str) -> set[str]:
    return {token.lower() for token in _TOKEN.findall(name)}


def short_name(joint: str) -> str:
    """Return the name of a joint without "_joint" at its end, which recorders often leave out."""
    return joint.removesuffix("_joint") or joint


def by_name(names: Iterable[str], joints: Sequence[str]) -> dict[str, Pattern]:
    """Return the patterns of columns whose names contain names of the robot's joints."""
    out: dict[str, Pattern] = {}
    place = {short_name(joint): k for k, joint in enumerate(joints)}
    place |= {joint: k for k, joint in enumerate(joints)}
    longest = sorted(filter(None, place), key=len, reverse=True)
    if not longest:
        return out
    any_joint = re.compile(rf"(?<![A-Za-z0-9])({'|'.join(map(re.escape, longest))})(?![A-Za-z0-9])")
    for name in names:
        if match := any_joint.search(name):
            out.setdefault(_starred(match), {})[place[match[1]]] = name
    return out


def _starred(joint: re.Match[str]) -> str:
    """Return the name of a column with * in place of the match of its joint."""
    start, end = joint.span()
    return f"{joint.string[:start]}*{joint.string[end:]}"


def by_number(names: Iterable[str], n: int | None) -> dict[str, Pattern]:
    """Return the patterns whose numbers run from 0 or from 1 without gaps.

    For a robot with one joint, a column needs no number.
    """
    if n == 1:
        return {name: {0: name} for name in names}
    out: dict[str, Pattern] = {}
    for name in names:
        for match in re.finditer("[0-9]+", name):
            if len(match[0]) < 4:
                out.setdefault(_starred(match), {})[int(match[0])] = name
    runs = {}
    for pattern, columns in out.items():
        count, first = len(columns), min(columns)
        if first <= 1 and max(columns) == first + count - 1 and (count > 1 or n is None):
            runs[pattern] = columns
    return runs


def _user_pattern(
    names: Sequence[str], texts: Mapping[str, str], role: str, pattern: str, wanted: Wanted
) -> Pattern:
    """Return the columns of a pattern from the user; * is the name of a joint or ends in its
    number.
    """
    form = re.compile(re.escape(pattern).replace(r"\*", "(.+)", 1).replace(r"\*", r"\1"))
    by_star = {}
    for text, name in (*texts.items(), *zip(names, names, strict=True)):
        if match := form.fullmatch(text):
            by_star[match[1]] = name
    groups = by_number(by_star, wanted.n) | by_name(by_star, wanted.joints)
    complete = [stars for stars, columns in groups.items() if wanted.kept(len(columns))]
    if not complete:
        how = f"a pattern with * for the joint's name or number, of {listed(names)}"
        stars = [*by_star][: wanted.n]
        if len(stars) == wanted.n:
            how = f"--joints {','.join(map(_shown, stars))}, in the order of the robot's joints"
        refuse(f"--columns {role}={pattern}: no such column of every joint", how)
    shortest = min(complete, key=len)
    return {joint: by_star[star] for joint, star in groups[shortest].items()}

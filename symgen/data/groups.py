"""Find the columns of a log among those of a table."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from symgen.data.columns import joints_of_file, matched, suggested
from symgen.data.csv_form import NO_HEADER, CsvForm, texts_of
from symgen.data.raw import (
    BESIDE,
    COLUMNS,
    IMU,
    NUMBERED,
    ROLES,
    Wanted,
    listed,
    refuse,
    refuse_currents,
)
from symgen.data.units import split_unit
from symgen.errors import plain

#: Role -> joint (from 0) -> log column.
Groups = dict[str, dict[int, str]]
# column name of an array in a message
_INDEXED = re.compile(r"(|.*[^A-Za-z])([A-Za-z]+)[\W_]*([0-9]+)\W*")
# column of a joint's name, or of a list of names
_NAMES = re.compile(r"(|.*[^A-Za-z])name(?:[\W_]*([0-9]+)\W*)?")
_PATTERN = {"t": "t=NAME", "q1": "q=*_NAME", "tau1": "tau=*_NAME"}


def with_joints(path: Path, form: CsvForm, wanted: Wanted) -> list[str]:
    """Return the header, with the joint that text columns name in its columns: field.name0 = elbow.

    Raises:
        LogError: the names change, or are not those of the robot's joints.
    """
    header = list(form.header)
    named: dict[tuple[str, int], str] = {}  # prefix and number of a column -> joint
    for k, name in enumerate(header):
        match = _NAMES.fullmatch(name)
        if match and (match[2] or form.first[0][k][:1] in ("[", "(")):
            texts = texts_of(path, form, k)
            if len(texts) > 1:
                what = f"the joints in column {name} change: {listed(texts)}"
                refuse(what, "one order of joints in a file")
            joints = texts[0].strip("[]()").split(",")
            numbers = [int(match[2])] if match[2] else range(len(joints))
            named |= {(match[1], j): x.strip(" '\"") for j, x in zip(numbers, joints, strict=True)}
    for k, name in enumerate(header):
        match = _INDEXED.fullmatch(name)
        if match and (joint := named.get((match[1], int(match[3])))):
            header[k] = f"{match[1]}{match[2]}.{joint}"
    if named:
        joints_of_file(wanted, [*named.values()])
    return header


def assigned(
    stored: Sequence[str], file: str, wanted: Wanted
) -> tuple[list[str], Groups, tuple[str, ...]]:
    """Assign roles to the columns of a table.

    Returns:
        Log names in the order of `stored`, log columns by role and joint, and notes on automatic
        matches.

    Raises:
        LogError: a column is missing, or occurs twice.
    """
    names = [name.strip() for name in stored]
    wanted = replace(wanted, joints=wanted.reading.joints or wanted.joints)
    columns = dict(wanted.reading.pairs)
    patterns = {o: columns.pop(o) for o, theirs in [*columns.items()] if "*" in theirs and o != "t"}
    for ours, theirs in columns.items():
        if ours not in ("t", *IMU) and NUMBERED.fullmatch(ours) is None:
            refuse(f"--columns {ours}={theirs}: a table has one column a joint", COLUMNS)
        if theirs not in names:
            refuse(f"there is no column {theirs!r} (--columns {ours})", listed(names))
    ours_of = {theirs: ours for ours, theirs in columns.items()}
    given = [
        ours_of.get(name, f"{name} (of the file)" if name in columns else name) for name in names
    ]
    # A header with a unit, q1 [deg], counts as q1 if there is only one such column.
    bare = [split_unit(name)[0] for name in given]
    count = Counter(bare)
    given = [
        own if (own == "t" or NUMBERED.fullmatch(own)) and count[own] == 1 else name
        for name, own in zip(given, bare, strict=True)
    ]
    from_zero = [role for role in ROLES if f"{role}0" in given]
    for place, name in enumerate(given):
        match = NUMBERED.fullmatch(name)
        if match and match[1] in from_zero:
            given[place] = f"{match[1]}{int(match[2]) + 1}"
    found, matches = matched(given, patterns, columns, wanted)
    groups = _groups(found, names, wanted)
    used = {column for group in groups.values() for column in group.values()}
    spare = [own for own, name in zip(names, found, strict=True) if own and name not in used]
    if matches and spare:
        matches = f"{matches}; not used: {listed(spare)}"
    notes = [f"columns by name: {matches}"] if matches else []
    if from_zero:
        notes.append(f"{', '.join(from_zero)} count joints from 0")
    return found, groups, tuple(f"{file}: {note}" for note in notes)


def _groups(names: list[str], stored: Sequence[str], wanted: Wanted) -> Groups:
    """Group column names by role and number: {"t": {0: t}, "q": {0: q1, ..}, ..}.

    Args:
        names: log names, or names that symgen does not know.
        stored: names of these columns in the file.
        wanted: the robot and the columns to read.
    """
    for name in ("t", *IMU, *filter(NUMBERED.fullmatch, names)):
        count = names.count(name)
        if count > 1:
            refuse(f"the column {name} occurs {count} times", f"each column once, or {NO_HEADER}")
    named = [name for name in names if name]
    numbered = [match for name in named if (match := NUMBERED.fullmatch(name))]
    numbers = {
        role: sorted(int(match[2]) for match in numbered if match[1] == role) for role in ROLES[1:]
    }
    measured = numbers["tau"] or (numbers["i"] if wanted.currents else []) or numbers.get("qr")
    time = "t" in named
    for role, present in (("t", time), ("q1", numbers["q"]), ("tau1", measured)):
        if role == "tau1" and not present and numbers["i"]:
            refuse_currents()
        if not present:
            missing = [r for r in ("q", "tau") if not numbers[r]]
            pairs = suggested(names, missing, wanted) or f'--columns "{_PATTERN[role]}"'
            how = f"{COLUMNS}, or {pairs}"
            others = [
                own
                for own, name in zip(stored, names, strict=True)
                if own and name != "t" and NUMBERED.fullmatch(name) is None
            ]
            if role == "t" and len(others) == 1 and not {",", "="} & {*others[0]}:
                stated = split_unit(others[0], time=True)[1]
                unsure = "" if stated else ", if it is a time; poses need the motion between them"
                how = f'--columns "t={plain(others[0])}"{unsure}'
            refuse(f"there is no column {role} among {listed(stored)}", how)
    imu = {k: name for k, name in enumerate(IMU) if name in named}
    if not wanted.currents or (numbers["tau"] and len(numbers["i"]) != len(numbers["q"])):
        del numbers["i"]
    groups = {"t": {0: "t"}}
    if len(imu) == len(IMU):
        groups["imu"] = imu
    for role, have in numbers.items():
        if role in BESIDE:  # only some joints may have it
            have = [number for number in have if 1 <= number <= len(numbers["q"])]
        elif have != list(range(1, len(have) + 1)):
            gap = ", ".join(f"{role}{number}" for number in have)
            what = f"of the columns {role}1, {role}2, .. there are only {gap}"
            refuse(what, f"{COLUMNS} of all joints")
        if have:
            groups[role] = {number - 1: f"{role}{number}" for number in have}
    return groups

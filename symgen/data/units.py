"""Units of the columns of a log, and their conversion to SI; times that are not one number.

An option or the header of a column states its unit; otherwise it is in SI. Dates need neither. Nor
do integer stamps since 1970 whose size and rate fit only one unit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import (
    ANGLES,
    CHANNELS,
    TIME_UNITS,
    TORQUES,
    Raw,
    Reading,
    Wanted,
    refuse,
    role_of,
)
from symgen.names import PRISMATIC

#: Sampling step of a robot log, s: shortest (a current loop of 20 kHz) and longest.
_STEPS = (5e-5, 0.25)
#: Stamps of the years 2000 to 2100, in s since 1970.
_DATES = (946684800.0, 4102444800.0)
_EXACT = 1 << 53  # integers that a double holds
#: Lowest bit that may be a sign, and smallest share of negative counts by it.
_LEAST_BIT, _NEGATIVE = 7, 0.05
_SECOND = 10**9  # ns
_VALUE = re.compile(r"([+-]?[0-9.]+(?:e[+-]?[0-9]+)?) *([a-zµμ]+)", re.IGNORECASE)  # 0.005 sec
_CLOCK = re.compile(r"(?:([0-9]+) days?,? )?(?:([0-9]+):)?([0-9]+):([0-9]+(?:\.[0-9]*)?)")
_DATE = re.compile("[0-9]{4}-[0-9]{2}-[0-9]{2}")
_MICRO = re.compile(r"(micro|u)(sec|secs|seconds)$", re.IGNORECASE)
_REST = re.compile(r"(.*?)(nano|n|micro|u)(sec|secs|seconds)", re.IGNORECASE)
#: Words for time in column names.
TIMES = {"t", "time", "timestamp", "stamp"}


@dataclass(frozen=True)
class Unit:
    """A unit.

    Attributes:
        name: its name for messages.
        quantity: what it measures.
        size: its size in the SI unit of the quantity; of a share, in the rated value.
        sign: number of the bit with the sign of a count; 0 for usual numbers.
        zero: number in the file of the value 0.
    """

    name: str
    quantity: str
    size: float
    sign: int = 0
    zero: float = 0.0

    @property
    def foreign(self) -> bool:
        """Whether symgen has to convert it."""
        return self.size != 1.0 or self.sign > 0

    def si(self, x: NDArray[Any]) -> NDArray[Any]:
        """Return values of a column (N,) in the SI unit.

        Raises:
            LogError: they are no counts with a sign in the bit `sign`.
        """
        if self.sign:
            limit = 2 << self.sign
            if np.nanmin(x, initial=0) < 0 or np.nanmax(x, initial=0) >= limit:
                refuse(f"--unit {self.name}: the column has other values", f"0 to {limit - 1}")
            top = limit // 2
            x = np.where(x >= top, top - x, x)
        return (x - self.zero) * self.size


def sign_bit(x: NDArray[Any]) -> int | None:
    """Return the bit with the sign of counts x (N,); None if they are usual numbers.

    With the bit as the sign, the steps between samples are smaller than with the counts as they are
    or with two's complement.
    """
    counts = np.nan_to_num(x, posinf=0.0)
    bit = int(counts.max(initial=0)).bit_length() - 1
    high = counts >= 2.0**bit
    if bit < _LEAST_BIT or high.mean() < _NEGATIVE or (counts < 0).any() or (counts % 1).any():
        return None
    complement = counts - high * (2 << bit)
    by_sign = Unit("", "", 1.0, bit).si(counts)
    usual = min(_roughness(counts), _roughness(complement))
    return bit if _roughness(by_sign) < 0.5 * usual else None


def _roughness(x: NDArray[Any]) -> float:
    return float(np.sum(np.diff(x) ** 2))


#: Quantity, unit, size in the SI unit, and written forms, in lower case without blanks. The first
#: unit of a quantity is its SI unit.
_TABLE = f"""
time  s     1     s sec secs second seconds
time  ms    1e-3  ms msec millis milliseconds
time  us    1e-6  us usec micros microseconds µs μs
time  ns    1e-9  ns nsec nanos nanoseconds
angle rad   1     rad rads radian radians
angle deg   {math.pi / 180.0}  deg degs degree degrees °
angle turn  {2.0 * math.pi}  turn turns rev revs
rate  rad/s 1     rad/s rads/s rad_s radps rad.s-1 rad*s^-1 rad rads
rate  deg/s {math.pi / 180.0}  deg/s degs/s degree/s degrees/s deg_s degps dps °/s deg °
rate  rpm   {2.0 * math.pi / 60.0}  rpm 1/min min-1 rev/min
length m    1     m meter meters metre metres
length mm   1e-3  mm
speed m/s   1     m/s m_s mps
speed mm/s  1e-3  mm/s mm_s mm
torque Nm   1     nm n.m n*m n-m n·m n⋅m
torque mNm  1e-3  mnm mn.m mn*m mn·m nmm n.mm
torque kNm  1e3   knm kn.m kn*m
torque Ncm  1e-2  ncm n.cm
force N     1     n
force mN    1e-3  mn
force kN    1e3   kn
torque %    1e-2  % percent
force  %    1e-2  % percent
current A   1     a amp amps ampere
current mA  1e-3  ma
duty  duty  1     duty
duty  %     1e-2  % percent
duty  V     1     v volt volts
duty  mV    1e-3  mv
voltage V   1     v volt volts
voltage mV  1e-3  mv
"""
#: Written form -> units; units of time; and quantity -> its SI unit.
_WRITTEN: dict[str, list[Unit]] = {}
_TIME: list[Unit] = []
_SI: dict[str, str] = {}
for _line in _TABLE.strip().splitlines():
    _quantity, _name, _size, *_forms = _line.split()
    _unit = Unit(_name, _quantity, float(_size))
    _SI.setdefault(_quantity, _name)
    for _form in _forms:
        _WRITTEN.setdefault(_form, []).append(_unit)
    if _quantity == "time":
        _TIME.append(_unit)
#: Forms that need brackets, because they could also be letters or words of a name.
_BRACKETED = set(
    "% m n a v mv volt volts duty ° °/s turn turns rev revs meter meters kn mn".split()
)
#: Counts of an encoder, with the count of the zero: ticks4096, ticks4096-2048, ticks4096/s.
_TICKS = re.compile("ticks([1-9][0-9]*)(?:-([0-9]+)|(/s))?")
#: A multiple of a unit, such as the step of a register: 0.1%, 0.229rpm.
_MULTIPLE = re.compile(r"([0-9]+(?:\.[0-9]+)?)(.+)")
#: A count with the sign in a bit, and its unit: sign10, sign10:0.1%.
_SIGN = re.compile("sign([1-9]|[1-5][0-9])(?::(.+))?")
_BRACKETS = re.compile(r"(.*?)[\s_]*[\[(<{]\s*([^\[\](){}<>]*?)\s*[\])>}]\s*()")
_BARE = "|".join(map(re.escape, sorted(set(_WRITTEN) - _BRACKETED)))
_SUFFIX = re.compile(rf"(.*?[a-z0-9*])[\s_.-]+({_BARE})([\s_]*[0-9]+)?", re.IGNORECASE)


def unit_of(text: str, quantity: str) -> Unit | None:
    """Return the unit that a text denotes for a quantity, or None."""
    return next((unit for unit in _units(text) if unit.quantity == quantity), None)


def _units(text: str) -> list[Unit]:
    """Return the units of several quantities that a text may denote."""
    form = re.sub(r"\s+", "", text).lower()
    if form in _WRITTEN:
        return _WRITTEN[form]
    if ticks := _TICKS.fullmatch(form):
        size = 2 * math.pi / int(ticks[1])
        quantity = "rate" if ticks[3] else "angle"
        return [Unit(form, quantity, size, zero=float(ticks[2] or 0))]
    if not (multiple := _MULTIPLE.fullmatch(form)):
        return []
    count = float(multiple[1])
    return [
        replace(unit, name=f"{multiple[1]}{unit.name}", size=count * unit.size)
        for unit in _WRITTEN.get(multiple[2], ())
        if count > 0 and unit.quantity != "time"
    ]


def is_unit(text: str) -> bool:
    """Return whether a text denotes a unit of any quantity."""
    return bool(_units(text))


def in_si(text: str) -> bool:
    """Return whether a text denotes a unit that needs no conversion, or none."""
    return not text or not all(unit.foreign for unit in _units(text))


def split_unit(name: str, time: bool | None = None) -> tuple[str, str]:
    """Return a column name without its unit, and the unit: ("q1", "deg") from "q1 [deg]".

    The unit is in brackets, or behind the last underscore or blank ("q1_deg"). A number behind it
    belongs to the name ("q_deg_1"). Only a time has a unit of time.

    Args:
        name: the column in the file.
        time: whether it contains the time; by default, whether its name has a word for it.
    """
    match = _BRACKETS.fullmatch(name) or _SUFFIX.fullmatch(name)
    if match is None or not match[1]:
        return name, ""
    if time is None:
        words = re.findall("[a-z]+", match[1].lower())
        time = not TIMES.isdisjoint(words)
    known = _units(match[2])
    if time not in [unit.quantity == "time" for unit in known]:
        return name, ""
    return match[1] + (match[3] or ""), match[2]


def unknown_unit(name: str) -> str:
    """Return text in brackets at the end of a column name that is neither a unit nor a number."""
    match = _BRACKETS.fullmatch(name)
    if match is None or not match[1] or is_unit(match[2]) or match[2].isdigit():
        return ""
    return match[2]


def durations(texts: Sequence[str]) -> NDArray[Any]:
    """Return texts of durations in whole ns, (N,) timedelta64.

    Raises:
        ValueError: one is no duration.
    """
    seconds = [_seconds(text.replace(",", ".").strip()) for text in texts]
    return np.array([round(_SECOND * t) for t in seconds], dtype="timedelta64[ns]")


def are_times(texts: Sequence[str]) -> bool:
    """Return whether texts are dates, such as 2026-01-31T13:00:00.250, or durations."""
    with suppress(ValueError):
        return all(map(_DATE.match, texts)) or len(durations(texts)) > 0
    return False


def _seconds(text: str) -> float:
    value, clock = _VALUE.fullmatch(text), _CLOCK.fullmatch(text)
    if value and (unit := unit_of(value[2], "time")):
        return float(value[1]) * unit.size
    if not clock or not (clock[2] or "." in text):  # 10:30 may be hours or minutes
        raise ValueError(f"column t: {text!r} is no duration")
    days, hours, minutes, seconds = (float(part or 0) for part in clock.groups())
    return ((24 * days + hours) * 60 + minutes) * 60 + seconds


def paired(names: Sequence[str], chosen: str) -> list[str]:
    """Return names of columns, with "sec+nanosec" for the whole seconds of a time in two columns.

    Args:
        names: the columns of the file.
        chosen: the column of the time that the user names, or two columns with + between them.
    """
    pairs = {match[1] + match[3]: match[0] for match in map(_REST.fullmatch, names) if match}
    seconds, _, rest = chosen.partition("+")
    if rest in names:
        pairs[seconds] = rest
    return [f"{name}+{pairs[name]}" if name in pairs else name for name in names]


def rest_of(name: str) -> str:
    """Return the second of the two columns of a time, or ""."""
    return name.partition("+")[2]


def is_sum(name: str) -> bool:
    """Return whether a name is that of two columns of a time, by their names."""
    return _REST.fullmatch(rest_of(name)) is not None


def joined(seconds: NDArray[Any], rest: NDArray[Any], column: str) -> NDArray[Any]:
    """Return whole seconds and the rest as times in whole ns, (N,) timedelta64.

    Args:
        seconds: (N,) whole seconds.
        rest: (N,) the rest, in us if the name of its column says so, otherwise in ns.
        column: that name.

    Raises:
        LogError: they are no whole seconds, or no rest of a second.
    """
    scale = 1000 if _MICRO.search(column) else 1
    ns = scale * rest.astype(np.int64)
    whole = (seconds % 1 == 0).all()
    whole &= ns.min() >= 0 and ns.max() < _SECOND
    if not whole or (np.ptp(seconds) > 1 and ns.max() < _SECOND / 1000):  # of ms or us
        what = f"t is not whole seconds, and their rest in {column!r}"
        refuse(what, "the rest in ns, or in us by a name such as usec")
    return (seconds.astype(np.int64) * _SECOND + ns).astype("timedelta64[ns]")


#: A conversion: columns of the file, their unit and its source, and the change.
Converted = tuple[str, str, str]


@dataclass(frozen=True)
class Units:
    """Conversion of the columns of a file to SI; the same for all rows of a file.

    Attributes:
        units: pairs of a role and its n units.
        ticks: time units of the file in a second.
        origin: stamp of the file that becomes t = 0, in its own unit; None if t is not shifted.
        conversions: list of the conversions.
        drive_unit: as in `Raw`.
    """

    units: tuple[tuple[str, tuple[Unit, ...]], ...] = ()
    ticks: float = 1.0
    origin: int | float | None = None
    conversions: tuple[Converted, ...] = ()
    drive_unit: str = "duty"

    def seconds(self, t: NDArray[Any]) -> NDArray[Any]:
        """Return stamps of the file as times in s; integers are subtracted exactly."""
        if self == IN_SI:
            return np.asarray(t)
        t = integer_ticks(np.asarray(t))
        if self.origin is not None:
            t = t - self.origin
        return np.asarray(t / self.ticks)

    def si(self, role: str, x: NDArray[Any]) -> NDArray[Any]:
        """Return a column or array of the file in SI units."""
        if role == "t":
            return self.seconds(x)
        units = dict(self.units).get(role)
        if units is None:
            return x
        out = np.array(x, dtype=np.float64)
        for unit, column in zip(units, out.T if x.ndim == 2 else [out], strict=True):
            column[:] = unit.si(column)
        return out

    def of(self, raw: Raw) -> Raw:
        """Return the content of a file with read-only arrays in SI units; its times are in s."""
        arrays = {}
        for role, x in raw.arrays.items():
            arrays[role] = self.si(role, x)
            arrays[role].setflags(write=False)
        return replace(raw, arrays=arrays, converted=self.conversions, drive_unit=self.drive_unit)


#: Units of a file in SI.
IN_SI = Units()


def integer_ticks(t: NDArray[Any]) -> NDArray[Any]:
    """Return dates as int64 nanoseconds since 1970, durations as int64 nanoseconds, and other
    stamps unchanged.
    """
    if t.dtype.kind in "Mm":
        return t.astype(f"{t.dtype.kind}8[ns]").astype(np.int64)
    fits = t.dtype == np.uint64 and t.max(initial=0) < 1 << 62
    return t.astype(np.int64) if fits else t


def units_of(raw: Raw, wanted: Wanted) -> Units:
    """Return the units of a file.

    Args:
        raw: the first rows of the file, unconverted.
        wanted: options, and types of the joints.

    Raises:
        LogError: a unit is unknown, an option has no column, or the rate contradicts a header.
    """
    arrays = {
        role: x for role, x in raw.arrays.items() if role != "t" and CHANNELS[role].quantities
    }
    widths = {role: (*x.shape, 1)[1] for role, x in arrays.items()}
    for column in filter(None, wanted.reading.unit):
        if role_of(column) not in widths:
            refuse(f"--unit {column}=..: there is no such column", ", ".join(widths))
    time = _time(raw, wanted.reading)
    found: list[tuple[str, tuple[Unit, ...]]] = []
    conversions = [*time.conversions]
    drive_unit = "duty"
    for role, width in widths.items():
        numbered = [f"{role}{j}" for j in range(1, width + 1)]
        columns = [raw.names.get(name, name) for name in numbered]
        units = _units_of_joints(role, columns, raw.arrays[role], wanted)
        if any(unit.foreign for unit, _ in units):
            found.append((role, tuple(unit for unit, _ in units)))
        of: dict[tuple[str, str], list[str]] = {}  # columns of each unit and its source
        for column, (unit, source) in zip(columns, units, strict=True):
            if unit.foreign:
                done = f"converted to {_SI[unit.quantity]}" if unit.size != 1.0 else "read so"
                text = f"in {unit.name} by {source}"
                of.setdefault((text, done), []).append(column)
        conversions += [(", ".join(alike), *about) for about, alike in of.items()]
        if role == "u":
            drive_unit = _drive_unit([unit for unit, _ in units])
    return Units(tuple(found), time.ticks, time.origin, tuple(conversions), drive_unit)


def _drive_unit(units: Sequence[Unit]) -> str:
    """Return the unit of all columns u1.., "duty" or "V".

    Raises:
        LogError: some are duty, and others are voltages.
    """
    volts = {unit.name.endswith("V") for unit in units if unit.name}
    if len(volts) > 1:
        refuse("u is duty for some joints and volts for others", "one of both: --unit u=V, or u=%")
    return "V" if True in volts else "duty"


def _units_of_joints(
    role: str, columns: Sequence[str], x: NDArray[Any], wanted: Wanted
) -> list[tuple[Unit, str]]:
    """Return the unit of the column of each joint, and its source."""
    # Text in brackets that differs between joints is a joint name.
    odd = {unknown_unit(column) for column in columns}
    common = odd.pop() if len(odd) == 1 else ""
    out = []
    channel = CHANNELS[role]
    width = len(columns)
    kept = [*range(width)] if channel.columns else wanted.kept(width)
    types = dict(zip(kept, wanted.sigma, strict=False))
    for j, column in enumerate(columns):
        quantity = channel.quantities[j if channel.columns else types.get(j) == PRISMATIC]
        if j not in kept:  # a fixed joint
            out.append((Unit("", quantity, 1.0), ""))
            continue
        unit, source = _unit_option(role, j, quantity, wanted.reading.unit), "--unit"
        if unit is None and wanted.reading.range and quantity in ("angle", "length"):
            low, high = wanted.reading.range[kept.index(j)]
            size = (high - low) / 200
            unit = Unit("-100..100", quantity, size, zero=-100 - low / size)
            source = "range in [log]"
        if unit is None:
            if role in TORQUES and (bit := sign_bit(x.T[j] if x.ndim == 2 else x)):
                what = f"column {column} has counts whose sign is in bit {bit}"
                signed = f"sign{bit}:0.1%" if role == "u" else f"sign{bit}"
                refuse(what, f"--unit {role}={signed}, or --unit {role}={_SI[quantity]}")
            text, source = split_unit(column, time=False)[1] or common, "the header"
            unit = unit_of(text or _SI[quantity], quantity)
            if unit is None:
                what = f"column {column!r}: {text!r} is no unit of {quantity}"
                refuse(what, f"{_accepted(quantity)}, or --unit {role}={_SI[quantity]}")
        if unit.name.endswith("%") and quantity != "duty":
            rated = _rated(wanted, column)[kept.index(j)]
            unit = replace(unit, size=unit.size * rated)
        out.append((unit, source))
    return out


def _rated(wanted: Wanted, column: str) -> Sequence[float]:
    """Return the torques of 100 %.

    Raises:
        LogError: they are unknown.
    """
    if wanted.drive is None or wanted.drive.rated is None:
        what = f"column {column!r} is in % of the rated torque, which is unknown"
        rated = "rated = [..] in [drive] of the robot file, in N m (N) on the side of tau"
        refuse(what, f"{rated}; or --columns u1=.. for the duty of servos")
    return wanted.drive.rated


def _unit_option(role: str, j: int, quantity: str, options: Mapping[str, str]) -> Unit | None:
    """Return the unit of a column from the option --unit."""
    for key in (f"{role}{j + 1}", role, ""):
        if key in options:
            text = options[key]
            sign = _SIGN.fullmatch(text)
            unit = unit_of((sign and sign[2]) or text, quantity)
            if sign and not (sign[2] and unit is None):
                unit = replace(unit or Unit("", quantity, 1.0), name=text, sign=int(sign[1]))
            if unit is None and key:
                how = (
                    f"{_accepted(quantity)}; other joints by their number: --unit {role}1={text},.."
                )
                if text in ANGLES:
                    how = f"{how}; all revolute joints: --unit {text}"
                what = f"--unit {key}={text}: no unit of {quantity}, which joint {j + 1} has"
                refuse(what, how)
            return unit
    return None


def _accepted(quantity: str) -> str:
    lines = filter(re.compile(quantity).match, _TABLE.splitlines())
    return ", ".join(line.split()[1] for line in lines)


def plausible_units(step: float) -> list[str]:
    """Return the units of time in which a sampling step is plausible for a robot log."""
    shortest, longest = _STEPS
    return [u.name for u in _TIME if shortest <= step * u.size <= longest]


def _time(raw: Raw, reading: Reading) -> Units:
    """Return the unit of the stamps."""
    stamps = integer_ticks(np.asarray(raw.arrays["t"]))
    column = raw.names.get("t", "t")
    if len(stamps) == 0 or stamps.dtype.kind not in "iuf":
        return IN_SI  # read_log refuses it by its type
    first = stamps[0].item()
    kind = {"M": "dates", "m": "durations"}.get(raw.arrays["t"].dtype.kind)
    if kind and reading.time_unit:
        refuse(f"column {column!r} (t) holds {kind}", "no --time-unit")
    if kind:
        return _ticking(column, _TIME[3], first, kind)
    if reading.time_unit:
        option = next(u for u in _TIME if u.name == reading.time_unit)
        return _ticking(column, option, first, f"in {option.name} by --time-unit")
    steps = np.diff(stamps)
    step = float(np.median(steps)) if len(steps) else math.nan
    plausible = plausible_units(step)
    header = unit_of(split_unit(column, time=True)[1], "time")
    if header is not None and header.foreign:
        if header.name not in plausible:
            how = " or ".join(f"--time-unit {name}" for name in plausible or TIME_UNITS)
            what = f"column {column!r} (t) is in {header.name} by its header, and its steps are"
            refuse(f"{what} {step:.4g}", f"a header with the unit of the numbers, or {how}")
        return _ticking(column, header, first, f"in {header.name} by the header")
    earliest, latest = _DATES
    dated = [u for u in _TIME if earliest <= first * u.size <= latest]
    if header is None and len(dated) == 1 and dated[0].foreign and dated[0].name in plausible:
        return _ticking(column, dated[0], first, f"{dated[0].name} since 1970 by size and rate")
    return IN_SI


def _ticking(column: str, unit: Unit, first: float, source: str) -> Units:
    """Return the conversion of times; stamps that doubles would round start from the first."""
    if not unit.foreign:
        return IN_SI
    seconds = abs(first) * unit.size
    long = seconds > _DATES[0] or abs(first) >= _EXACT
    done = "converted to s" + (", from the first sample on" if long else "")
    return Units(
        ticks=round(1 / unit.size),
        origin=first if long else None,
        conversions=((column, source, done),),
    )

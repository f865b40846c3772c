"""Units of the columns of a log, and their conversion to SI.

A column is converted only if two independent signs agree: the unit in its header, the slope of q
against qd, and the limits of the robot; for time, the header or a date, and the sampling rate. A
column with one sign is refused; the option in the message settles it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import rms
from symgen.data.raw import FloatArray, Reading, Wanted, refuse
from symgen.names import PRISMATIC

#: If a revolute joint moves further than this, rad, its positions are probably in degrees.
MAX_RANGE = 50.0
#: Share of its range that a joint may be beyond its limits; gears and offsets cause less.
BEYOND = 1.0
#: Time step of a log of a robot, s: shortest (a current loop of 20 kHz) and longest.
_STEPS = (5e-5, 0.25)
#: Stamps of the years 2000 to 2100, in s since 1970.
_DATES = (946684800.0, 4102444800.0)
#: Relative error of a slope that shows a unit of which the header says nothing.
_AGREE = 0.05
#: Logarithm of a slope's error that is none of the unit: half of rpm over deg/s, which is 6.
_APART = 0.5 * math.log(6.0)
_USUALLY = (0.01, 0.99)  # quantiles of the range of a channel
_EXACT = 1 << 53  # integers that a double holds
#: Words for time in column names.
TIMES = {"t", "time", "timestamp", "stamp"}
_DEGREE, _TURN = math.pi / 180.0, 2.0 * math.pi


@dataclass(frozen=True)
class Unit:
    """A unit: its name for messages, and its size in the SI unit of the quantity."""

    name: str
    quantity: str
    size: float

    @property
    def foreign(self) -> bool:
        """Whether symgen has to convert it."""
        return self.size != 1.0


def _units(quantity: str, **sizes: float) -> list[Unit]:
    return [Unit(name, quantity, size) for name, size in sizes.items()]


_TIME = _units("time", s=1.0, ms=1e-3, us=1e-6, ns=1e-9)
#: Written form, in lower case without blanks -> unit.
_WRITTEN: dict[str, tuple[Unit, ...]] = {}
for _unit, _forms in (
    *zip(_TIME, ("s sec secs second seconds", "ms msec millis milliseconds",
                 "us usec micros microseconds µs μs", "ns nsec nanos nanoseconds"), strict=True),
    (Unit("rad", "angle", 1.0), "rad rads radian radians"),
    (Unit("deg", "angle", _DEGREE), "deg degs degree degrees °"),
    (Unit("turn", "angle", _TURN), "turn turns rev revs"),
    (Unit("rad/s", "rate", 1.0), "rad/s rads/s rad_s radps rad.s-1 rad*s^-1 rad rads"),
    (Unit("deg/s", "rate", _DEGREE), "deg/s degs/s degree/s degrees/s deg_s degps dps °/s deg °"),
    (Unit("rpm", "rate", _TURN / 60.0), "rpm 1/min min-1 rev/min"),
    (Unit("m", "length", 1.0), "m meter meters metre metres"),
    (Unit("mm", "length", 1e-3), "mm"),
    (Unit("m/s", "speed", 1.0), "m/s m_s mps"),
    (Unit("mm/s", "speed", 1e-3), "mm/s mm_s mm"),
    (Unit("Nm", "torque", 1.0), "nm n.m n*m n-m n·m n⋅m"),
    (Unit("mNm", "torque", 1e-3), "mnm mn.m mn*m mn·m nmm n.mm"),
    (Unit("kNm", "torque", 1e3), "knm kn.m kn*m"),
    (Unit("Ncm", "torque", 1e-2), "ncm n.cm"),
    (Unit("N", "force", 1.0), "n"),
    (Unit("kN", "force", 1e3), "kn"),
    (Unit("A", "current", 1.0), "a amp amps ampere"),
    (Unit("mA", "current", 1e-3), "ma"),
):  # fmt: skip
    for _form in _forms.split():
        _WRITTEN[_form] = (*_WRITTEN.get(_form, ()), _unit)
#: Forms that need brackets: without them they are letters or words of a name.
_BARE = set(_WRITTEN) - set("m n a ° °/s turn turns rev revs meter meters kn".split())
_BRACKETS = re.compile(r"(.*?)[\s_]*[\[(<{]\s*([^\[\](){}<>]*?)\s*[\])>}]\s*")
_SUFFIXES = [  # rad_s, then rad
    re.compile(rf"(.*[A-Za-z0-9])[\s_.-]+([^\W\d_]+{more})") for more in ("[_/][a-z]+", "")
]
#: Quantities of the roles of a log: of revolute joints, and of prismatic ones.
QUANTITIES = {
    "q": ("angle", "length"),
    "qs": ("angle", "length"),
    "qr": ("angle", "length"),
    "qdr": ("rate", "speed"),
    "qd": ("rate", "speed"),
    "tau": ("torque", "force"),
    "i": ("current", "current"),
}
_SI = {"angle": "rad", "rate": "rad/s", "length": "m", "speed": "m/s", "torque": "Nm"}
_SI |= {"force": "N", "current": "A"}
#: Signs of columns that are no motion.
_OTHER = ("header", "limits or motion")
#: What columns of a robot without a header may be in.
_USUAL = {"angle": "deg", "rate": "deg/s", "length": "mm", "speed": "mm/s"}


def unit_of(text: str, quantity: str) -> Unit | None:
    """Return the unit that a text means for a quantity, or None."""
    form = re.sub(r"\s+", "", text).lower().replace("²", "2")
    return next((u for u in _WRITTEN.get(form, ()) if u.quantity == quantity), None)


def split_unit(name: str, time: bool | None = None) -> tuple[str, str]:
    """Return a column name without its unit, and the unit: ("q1", "deg") from "q1 [deg]".

    The unit stands in brackets, or behind the last underscore or blank ("q1_deg"). A number behind
    it belongs to the name ("q_deg_1"). Only a time has a unit of time.

    Args:
        name: the column in the file.
        time: whether it holds the time; by default, whether its name has a word for it.
    """
    stem, unit, number = name, "", ""
    if match := _BRACKETS.fullmatch(name):
        stem, unit = match[1], match[2]
    else:
        end = re.search(r"[\s_]*[0-9]+$", name)
        stem, number = (name[: end.start()], end[0]) if end else (name, "")
        matches = [m for form in _SUFFIXES if (m := form.fullmatch(stem))]
        for found in matches:
            if found[2].lower() in _BARE:
                stem, unit = found[1], found[2]
                break
    known = _WRITTEN.get(_form_of(unit), ())
    if time is None:
        time = not TIMES.isdisjoint(word.lower() for word in re.findall("[A-Za-z]+", stem))
    if not stem or not any((u.quantity == "time") == time for u in known):
        return name, ""
    return stem + number, unit


def unknown_unit(name: str) -> str:
    """Return text in brackets at the end of a column name that is no unit and no number."""
    match = _BRACKETS.fullmatch(name)
    odd = match is not None and match[1] and _form_of(match[2]) not in _WRITTEN
    return match[2] if match and odd and not match[2].isdigit() else ""


def _form_of(text: str) -> str:
    return re.sub(r"\s+", "", text).lower()


#: What is converted: columns of the file, their unit with its signs, and what is done.
Converted = tuple[str, str, str]


@dataclass(frozen=True)
class Units:
    """How columns of a file become SI; the same for all rows of a file.

    Attributes:
        sizes: pairs of a role and its (n,) factors.
        ticks: time units of the file in a second.
        origin: stamp of the file that becomes t = 0, in its own unit; None if t is not shifted.
        told: what is converted.
    """

    sizes: tuple[tuple[str, tuple[float, ...]], ...] = ()
    ticks: float = 1.0
    origin: int | float | None = None
    told: tuple[Converted, ...] = ()

    def seconds(self, t: NDArray[Any]) -> NDArray[Any]:
        """Return stamps of the file as times in s; integers are subtracted exactly."""
        t = whole_ticks(np.asarray(t))
        if self.origin is None and self.ticks == 1.0:
            return t
        return np.asarray((t if self.origin is None else t - self.origin) / self.ticks)

    def si(self, role: str, x: NDArray[Any]) -> NDArray[Any]:
        """Return a column or array of the file in SI units."""
        sizes = dict(self.sizes).get(role)
        if sizes is None:
            return x
        out = np.multiply(x, sizes if x.ndim == 2 else sizes[0], order="K")
        out.setflags(write=False)
        return np.asarray(out)


#: Units of a file in SI.
IN_SI = Units()


def whole_ticks(t: NDArray[Any]) -> NDArray[Any]:
    """Return dates as int64 nanoseconds since 1970, other stamps as they are."""
    if t.dtype.kind == "M":
        return t.astype("datetime64[ns]").astype(np.int64)
    return t.astype(np.int64) if t.dtype == np.uint64 and t.max(initial=0) < 1 << 62 else t


@dataclass(frozen=True)
class Sample:
    """Some rows of a file, unconverted: blocks of times, and of arrays by role.

    Attributes:
        names: log column ("t", "q1") -> column of the file.
        blocks: t (K,), and role -> (K, n).
    """

    names: Mapping[str, str]
    blocks: Sequence[tuple[NDArray[Any], Mapping[str, FloatArray]]]

    def shown(self, column: str) -> str:
        """Return a column for a message, with its name in the file."""
        own = self.names.get(column, column)
        return column if own == column else f"{own!r} ({column})"


def units_of(sample: Sample, wanted: Wanted) -> Units:
    """Decide the units of a file.

    Raises:
        LogError: a unit has one sign only, two signs disagree, or an option has no column.
    """
    found = IN_SI
    if not sample.blocks or not any(len(t) for t, _ in sample.blocks):
        return found
    found = _time(sample, wanted.reading)
    roles = {role: x.shape[1] for role, x in sample.blocks[0][1].items() if role in QUANTITIES}
    if len(set(roles.values())) > 1:
        return found  # refused with its shapes
    slopes = tuple(_slopes(sample, found))
    sizes, told = _Joints(sample, wanted, roles, slopes).decided()
    return Units(tuple(sizes.items()), found.ticks, found.origin, (*found.told, *told))


# Time.


def plausible_units(step: float) -> list[str]:
    """Return the units of time in which a step between samples is one of a robot's log."""
    return [u.name for u in _TIME if _STEPS[0] <= step * u.size <= _STEPS[1]]


def _time(sample: Sample, reading: Reading) -> Units:
    blocks = [t for t, _ in sample.blocks if len(t)]
    shown, dates = sample.shown("t"), blocks[0].dtype.kind == "M"
    stamps = [whole_ticks(t) for t in blocks]
    if stamps[0].dtype.kind not in "iuf":
        return IN_SI  # refused with its type
    first = stamps[0][0].item()
    steps = np.concatenate([np.diff(t) for t in stamps])
    step = float(np.median(steps)) if len(steps) else math.nan
    header = unit_of(split_unit(sample.names.get("t", "t"), time=True)[1], "time")
    plausible = [u for u in _TIME if u.name in plausible_units(step)]
    dated = [u for u in _TIME if _DATES[0] <= first * u.size <= _DATES[1]]
    if dates:
        if reading.time_unit:
            refuse(f"column {shown} holds dates", "no --time-unit")
        return _ticking(sample, _TIME[3], first, "dates")
    if reading.time_unit:
        asked = next(u for u in _TIME if u.name == reading.time_unit)
        return _ticking(sample, asked, first, f"in {asked.name}, as --time-unit says")
    rates = " and ".join(f"{1 / (step * u.size):.4g} Hz in {u.name}" for u in _TIME[:3] if step > 0)
    how = " or ".join(f"--time-unit {u.name}" for u in (plausible or _TIME))
    if header is not None and header.foreign:
        if header not in plausible:
            what = f"column {shown} is in {header.name} by its header, but its steps mean {rates}"
            refuse(what, f"a header with the unit of the numbers, or {how}")
        return _ticking(sample, header, first, f"in {header.name}, as header and rate say")
    seconds = _TIME[0] in plausible
    if not seconds and header is None and len(dated) == 1 and dated[0] in plausible:
        unit = dated[0]
        return _ticking(sample, unit, first, f"{unit.name} since 1970, as size and rate say")
    return IN_SI


def _ticking(sample: Sample, unit: Unit, first: float, says: str) -> Units:
    """Return the conversion of time; stamps that doubles round are counted from the first."""
    long = unit.foreign and (abs(first) * unit.size > _DATES[0] or abs(first) >= _EXACT)
    if not unit.foreign:
        return IN_SI
    done = "converted to s" + (", from the first sample on" if long else "")
    own = sample.names.get("t", "t")
    told = (own, says, done)
    return Units(ticks=round(1 / unit.size), origin=first if long else None, told=(told,))


def _slopes(sample: Sample, units: Units) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield slopes of q and the measured speeds beside them, (K, n) each, in units of the file."""
    for stamps, arrays in sample.blocks:
        q, qd = arrays.get("q"), arrays.get("qd")
        t = np.asarray(units.seconds(stamps), dtype=np.float64)
        if q is None or qd is None or q.shape != qd.shape:
            continue
        with np.errstate(all="ignore"):
            slope = (q[2:] - q[:-2]) / (t[2:] - t[:-2])[:, None]
        good = np.isfinite(slope).all(axis=1) & np.isfinite(qd[1:-1]).all(axis=1)
        yield slope[good], qd[1:-1][good]


def slope_ratios(slope: FloatArray, qd: FloatArray) -> FloatArray:
    """Return slope of q over measured speed by joint, (n,); NaN where they do not move together."""
    if len(slope) == 0:
        return np.full(qd.shape[1], np.nan)
    moved, told = rms(slope), rms(qd)
    # At rest both are noise with an arbitrary ratio: require that they move together.
    together = np.mean(slope * qd, axis=0) >= 0.5 * moved * told
    sound = together & (moved > 0) & (told > 0)
    return np.where(sound, moved / np.where(told > 0, told, 1.0), np.nan)


# Joints.


@dataclass(frozen=True)
class _Choice:
    """Units of the columns of a joint: role -> unit, and the signs for those that are not SI."""

    units: Mapping[str, Unit]
    signs: tuple[str, ...]
    sure: bool = True


@dataclass(frozen=True)
class _Joints:
    """The decision for the columns of joints."""

    sample: Sample
    wanted: Wanted
    roles: Mapping[str, int]
    slopes: Sequence[tuple[FloatArray, FloatArray]]

    def decided(self) -> tuple[dict[str, tuple[float, ...]], list[Converted]]:
        """Return factors by role, and what is converted.

        Raises:
            LogError: see `units_of`.
        """
        for column in filter(None, self.wanted.reading.unit):
            if re.sub("[0-9]+", "", column) not in self.roles:
                refuse(f"--unit {column}=..: there is no such column", ", ".join(self.roles))
        ratios, n = self._ratios(), self.roles.get("q", 0)
        choices = self._with_group([self._motion(j, ratios[j]) for j in range(n)], ratios)
        for j, choice in enumerate(choices):
            others = {r: self._other(r, j, choice) for r in self.roles if r not in ("q", "qd")}
            choices[j] = replace(choice, units={**choice.units, **others})
        sizes, told = {}, list[Converted]()
        for role in self.roles:
            units = [c.units[role] for c in choices]
            if not any(u.foreign for u in units):
                continue
            sizes[role] = tuple(u.size for u in units)
            for unit in dict.fromkeys(u for u in units if u.foreign):
                at = [j for j, u in enumerate(units) if u == unit]
                columns = ", ".join(self._own(role, j) for j in at)
                si = _SI[self._quantity(role, at[0])]
                signs = choices[at[0]].signs if role in ("q", "qd") else _OTHER
                why = "--unit" if self._given(role, at[0]) else " and ".join(signs)
                told.append((columns, f"in {unit.name} by {why}", f"converted to {si}"))
        return sizes, told

    def _own(self, role: str, j: int) -> str:
        column = f"{role}{j + 1}"
        return self.sample.names.get(column, column)

    def _quantity(self, role: str, j: int) -> str:
        sigma = self.wanted.sigma
        return QUANTITIES[role][j < len(sigma) and sigma[j] == PRISMATIC]

    def _si(self, role: str, j: int) -> Unit:
        quantity = self._quantity(role, j)
        return Unit(_SI[quantity], quantity, 1.0)

    def _given(self, role: str, j: int) -> Unit | None:
        """Return the unit of a column from the option --unit."""
        quantity, unit = self._quantity(role, j), self.wanted.reading.unit
        for key in (f"{role}{j + 1}", role, ""):
            if key in unit:
                found = unit_of(unit[key], quantity)
                if found is None and key:
                    refuse(f"--unit {key}={unit[key]}: no unit of {quantity}", _accepted(quantity))
                return found
        return None

    def _header(self, role: str, j: int) -> Unit | None:
        """Return the unit of a column from its header."""
        if self._given(role, j):
            return None
        quantity, (_, text) = self._quantity(role, j), split_unit(self._own(role, j), time=False)
        odd = unknown_unit(self._own(role, j))
        found = unit_of(text, quantity) if text else None
        # Text in brackets that differs between joints is a name of theirs.
        same = all(unknown_unit(self._own(role, k)) == odd for k in range(self.roles[role]))
        wrong = text if text and found is None else odd if same else ""
        if wrong:
            what = f"column {self._own(role, j)!r}: {wrong!r} is no unit of {quantity}"
            refuse(what, f"{_accepted(quantity)}, or --unit {role}={_SI[quantity]}")
        return found

    def _ratios(self) -> FloatArray:
        n = self.roles.get("q", 0)
        if not self.slopes or self.roles.get("qd") != n:
            return np.full(n, np.nan)
        slope, qd = (np.concatenate(parts) for parts in zip(*self.slopes, strict=True))
        return slope_ratios(slope, qd)

    def _motion(self, j: int, ratio: float) -> _Choice:
        """Choose the units of q and qd of a joint."""
        roles = [role for role in ("q", "qd") if role in self.roles]
        header = {role: self._header(role, j) for role in roles}
        pairs = [
            dict(zip(roles, units, strict=True))
            for units in product(*(self._candidates(role, j, header[role]) for role in roles))
        ]
        tells = len(roles) == 2 and np.isfinite(ratio)
        fits = [p for p in pairs if tells and self._fits(j, p, header, ratio)]
        if tells and not fits and any(u is not None and u.foreign for u in header.values()):
            q, qd = self._own("q", j), self._own("qd", j)
            what = f"the slope of {q!r} is {ratio:.3g} times {qd!r}: their units do not fit"
            refuse(what, "--unit with the units of both, such as --unit q=deg,qd=rad/s")
        pairs = fits or pairs
        # Speeds beyond their limits are no reason: many files have limits that nothing keeps.
        pairs = [p for p in pairs if not ("q" in p and self._beyond("q", j, p["q"]))] or pairs
        choices = []
        for units in pairs:
            asked = {r: u for r, u in units.items() if u.foreign and not self._given(r, j)}
            signs = [f"the header of {self._own(r, j)!r}" for r in asked if header[r]]
            si = {**units, **{r: self._si(r, j) for r in asked}}
            if asked and fits and not self._fits(j, si, header, ratio):
                signs.append(f"the slope of {self._own('q', j)!r} ({ratio:.3g} times qd{j + 1})")
                signs += ["--unit"] * any(self._given(r, j) for r in roles)
            signs += [
                f"the range of {self._own(r, j)!r}"
                for r in asked
                if self._beyond(r, j, self._si(r, j))
            ]
            choices.append(_Choice(units, tuple(signs), not asked or len(signs) > 1))
        # SI, if nothing is against it; else what has most signs.
        return max(choices, key=lambda c: (not _foreign(c), len(c.signs)))

    def _fits(
        self, j: int, units: Mapping[str, Unit], header: Mapping[str, Unit | None], ratio: float
    ) -> bool:
        """Whether the slope of q over qd is that of two units; closely, if one is guessed."""
        guessed = any(
            u.foreign and not header[role] and not self._given(role, j) for role, u in units.items()
        )
        off = abs(math.log(ratio * units["q"].size / units["qd"].size))
        return off < (_AGREE if guessed else _APART)

    def _candidates(self, role: str, j: int, header: Unit | None) -> Sequence[Unit]:
        known = self._given(role, j) or header
        usual = unit_of(_USUAL[self._quantity(role, j)], self._quantity(role, j))
        assert usual is not None
        return [known] if known else [self._si(role, j), usual]

    def _with_group(self, choices: list[_Choice], ratios: FloatArray) -> list[_Choice]:
        """Give a joint without signs of its own the units of joints with the same header.

        Raises:
            LogError: a joint has one sign only.
        """
        out = list(choices)
        for j, own in enumerate(choices):
            alike = [
                c for k, c in enumerate(choices)
                if c.sure and self._kind(k) == self._kind(j) and np.isfinite(ratios[k])
            ]  # fmt: skip
            unknown = not np.isfinite(ratios[j])
            units = alike[0].units if alike else own.units
            if unknown and _foreign(alike[0] if alike else own) and alike:
                if any(c.units != units for c in alike):
                    self._refuse(j, replace(own, units=units, signs=("joints that move differ",)))
                out[j] = replace(own, units=units, sure=True)
            elif not own.sure:
                self._refuse(j, own)
        return out

    def _kind(self, j: int) -> tuple[object, ...]:
        """Return what joints of one group have in common: quantity, header and option."""
        return tuple(
            (self._quantity(r, j), self._header(r, j), self._given(r, j))
            for r in ("q", "qd")
            if r in self.roles
        )

    def _refuse(self, j: int, choice: _Choice) -> NoReturn:
        asked = {r: u for r, u in choice.units.items() if u.foreign and not self._given(r, j)}
        columns = " and ".join(f"column {self._own(r, j)!r}" for r in asked)
        unit = ", ".join(dict.fromkeys(u.name for u in asked.values()))
        what = f"{columns} may be in {unit}: only {' and '.join(choice.signs)} says so"
        foreign = ",".join(f"{r}={u.name}" for r, u in asked.items())
        si = ",".join(f"{r}={_SI[self._quantity(r, j)]}" for r in asked)
        accepted = f"a second sign (speeds, [limits]), or --unit {foreign}, or --unit {si}"
        refuse(what, f"{accepted} and, if they are wrong, wider limits in the robot file")

    def _other(self, role: str, j: int, choice: _Choice) -> Unit:
        """Return the unit of a column that is no motion."""
        si = self._si(role, j)
        unit = self._given(role, j) or self._header(role, j) or si
        same = role in ("qs", "qr") and choice.units["q"] == unit
        if self._given(role, j) or not unit.foreign or same:
            return unit
        if not (self._beyond(role, j, si) and not self._beyond(role, j, unit)):
            signs = (f"the header of {self._own(role, j)!r}",)
            self._refuse(j, _Choice({role: unit}, signs))
        return unit

    def _beyond(self, role: str, j: int, unit: Unit) -> bool:
        """Whether a column in a unit is far beyond what the joint can do."""
        x = np.concatenate([arrays[role][:, j] for _, arrays in self.sample.blocks])
        x = x[np.isfinite(x)] * unit.size
        if len(x) == 0:
            return False
        low, high = map(float, np.quantile(x, _USUALLY))  # without outliers
        limits, drive = self.wanted.limits, self.wanted.drive
        if drive is not None and not np.array_equal(drive.ratio, np.eye(len(drive.ratio))):
            return False  # limits are those of the joint side
        if limits is not None and role in ("q", "qs", "qr") and j < len(limits.position or ()):
            assert limits.position is not None
            least, most = limits.position[j]
            return max(least - low, high - most) > BEYOND * (most - least)
        if limits is not None and role in ("qd", "tau"):
            known = (limits.velocity if role == "qd" else limits.torque) or ()
            return j < len(known) and max(-low, high) > (1 + BEYOND) * known[j]
        turning = role == "q" and self._quantity(role, j) == "angle"
        return turning and high - low > MAX_RANGE


def _foreign(choice: _Choice) -> bool:
    return any(u.foreign for u in choice.units.values())


def _accepted(quantity: str) -> str:
    names = dict.fromkeys(
        u.name for units in _WRITTEN.values() for u in units if u.quantity == quantity
    )
    return ", ".join(names)

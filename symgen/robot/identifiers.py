"""Names that are valid in C, and valid replacements for those that are not."""

from __future__ import annotations

import itertools
import re
import unicodedata
from collections.abc import Iterable

MAX_NAME = 64
_ENDING = 48  # letters of a name in C
_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
# C headers that a generated NAME.h would hide.
_HEADERS = frozenset(
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal "
    "stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings "
    "tgmath threads time uchar wchar wctype unistd memory features".split()
)
# Keywords of C and C++, and names of symgen's own variables.
_KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long main register restrict return short signed sizeof static struct switch "
    "typedef union unsigned void volatile while asm bool catch class delete false friend mutable "
    "namespace new operator private protected public template this throw true try using virtual "
    "abs sign sqrt sin cos tan exp tanh min max pi g taur".split()
)
_RESERVED = re.compile(
    r"X_\w*|(q|qd|qdd|tau|i)\d*|(XX|XY|XZ|YY|YZ|ZZ|MX|MY|MZ|M|IA|IAM|FS|FV|OF|FSM|FVM)(\d+|L)R?"
)
# A coefficient becomes NAME_coefficient in C. Other names of a package have lower-case letters and
# underscores, except for these.
_COEFFICIENT = re.compile(r"[A-Z][A-Za-z0-9]*", re.ASCII)
_API = frozenset(
    "JOINTS PARAMETERS INERTIAL NEAR ROUND VERSION OK OUTLIER CHANGING STANDARD WIDTH".split()
)


def fits_c(name: str) -> bool:
    """Return whether a name is a valid identifier in C."""
    fits = _IDENTIFIER.fullmatch(name) is not None and len(name) <= MAX_NAME
    return fits and name not in _KEYWORDS


def default_prefix(robot: str, dtype: str) -> str:
    """Return the default prefix of a package."""
    return f"{robot}f" if dtype == "float" else robot


def is_robot_name(name: str) -> bool:
    """Return whether a robot can have this name: NAME.h must not hide a header of C."""
    return fits_c(name) and name not in _HEADERS


def is_geometry_name(name: str) -> bool:
    """Return whether a length can have this name: parameters and variables must not use it."""
    return fits_c(name) and _RESERVED.fullmatch(name) is None


def is_coefficient_name(name: str) -> bool:
    """Return whether a coefficient of an effect can have this name; in C it becomes NAME_name."""
    return is_geometry_name(name) and _COEFFICIENT.fullmatch(name) is not None and name not in _API


def c_identifiers(names: Iterable[str], empty: str) -> list[str]:
    """Return an ending of a C identifier for each name: letters, digits and underscores.

    If a name is already taken, it gets a number: a_b, a_b_2.

    Args:
        names: any texts.
        empty: the ending of a name without letters and digits.
    """
    out: list[str] = []
    taken: set[str] = set()
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9]+", "_", _ascii(name)).strip("_")[:_ENDING] or empty
        numbered = itertools.chain([plain], (f"{plain}_{k}" for k in itertools.count(2)))
        own = next(ending for ending in numbered if ending not in taken)
        taken.add(own)
        out.append(own)
    return out


def c_fields(names: Iterable[str]) -> list[str]:
    """Return a variable of C in lower case for each name, which no macro of a board hides: A1
    becomes a1, float becomes joint_float.
    """
    lower = (ending.lower() for ending in c_identifiers(names, "joint"))
    fields = (name if fits_c(name) else f"joint_{name}" for name in lower)
    return c_identifiers(fields, "joint")


def c_comment(name: str) -> str:
    """Return a name as text for a C comment; the text cannot end the comment."""
    return re.sub(r"[^A-Za-z0-9 ._,:+()-]", "_", _ascii(name))[:_ENDING]


def _ascii(text: str) -> str:
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()


def robot_name(text: str) -> str:
    """Return the nearest valid robot name: ur5-e becomes ur5_e."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", _ascii(text)).strip("_")[: MAX_NAME - 6]
    return name if is_robot_name(name) else f"robot_{name}".rstrip("_")

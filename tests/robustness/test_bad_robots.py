"""A bad robot file is refused with one line that names its place; an odd valid one is right."""

import math
import signal
from contextlib import contextmanager

import numpy as np
import pytest
from oracles.numeric_rank import numeric_rank
from oracles.transforms import Arm, column_names, energy_regressor

import symgen
from symgen.errors import RobotError, SymgenError

ROBOT = '[robot]\nname = "arm"\n'
GEOMETRY = "[geometry]\nL1 = 0.5\nL2 = 0.3\n"
JOINT = "[[joint]]\n"
TWO = ROBOT + JOINT + JOINT
COUPLING = "[[coupling]]\njoints = [{}, {}]\nratio = {}\n"


@contextmanager
def within(seconds):
    """Fail, instead of hanging the whole suite, where something takes longer."""

    def late(*_):
        raise TimeoutError(f"longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def refused(text, *words):
    with within(5), pytest.raises(RobotError) as caught:
        symgen.parse_robot(text, "file.toml")
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 1500
    assert message.startswith("file.toml: ")
    for word in words:
        assert word in message, message


def one(key, value):
    """Return a file whose second joint has this key."""
    return ROBOT + GEOMETRY + JOINT + JOINT + f"{key} = {value}\n"


def quoted(expression):
    return "'''" + expression + "'''"


FILES = {
    "empty": ("", ["robot"]),
    "no joint": (ROBOT, ["joint"]),
    "not TOML": (ROBOT + "[[joint]\n", ["TOML", "line 3"]),
    "nul byte": (ROBOT + "\0", ["TOML"]),
    "deep list": (ROBOT + JOINT + "d = " + "[" * 5000 + "]" * 5000, []),
    "deep table": (TWO + "[a" + ".a" * 3000 + "]\n", ["a"]),
    "key twice": (ROBOT + 'name = "b"\n' + JOINT, ["TOML", "line 3"]),
    "table twice": (ROBOT + ROBOT + JOINT, ["TOML", "robot"]),
    "unknown table": (TWO + "[foo]\n", ["foo", "unknown key", "coupling"]),
    "unknown robot key": (ROBOT + "foo = 1\n" + JOINT, ["robot", "'foo'", "gravity"]),
    "unknown joint key": (one("alfa", 1), ["joint 2", "'alfa'", "unknown key", "alpha"]),
    "Craig's length": (
        one("a", 0.4),
        ["joint 2", "'a'", "d is the length along x", "r the length"],
    ),
    "standard table": (
        ROBOT + 'convention = "standard"\n' + JOINT,
        ["'convention'", "d is the length along x"],
    ),
    "a length without value": (
        TWO + 'd = "a2"\n',
        ["joint 2", "'d'", "'a2'", "[geometry]"],
    ),
    "friction in a word": (one("friction", '"none"'), ["joint 2", "'friction'", "[]"]),
    "unknown coupling key": (
        TWO + COUPLING.format(1, 2, 1) + "foo = 1\n",
        ["coupling 1", "'foo'", "ratio"],
    ),
    "unknown payload key": (TWO + "[payload]\njoint = 1\nfoo = 1\n", ["payload", "'foo'"]),
    "unknown limits key": (TWO + "[limits]\nfoo = 1\n", ["limits", "'foo'", "velocity"]),
    "joint is a table": (ROBOT + "[joint]\nsigma = 0\n", ["joint"]),
    "joint is a number": ("joint = 3\n" + ROBOT, ["joint"]),
    "name missing": ("[robot]\n" + JOINT, ["robot", "'name'"]),
    "name is a number": ("[robot]\nname = 3\n" + JOINT, ["robot", "'name'"]),
    "name empty": ('[robot]\nname = ""\n' + JOINT, ["robot", "'name'"]),
    "name not ASCII": ('[robot]\nname = "ärm"\n' + JOINT, ["robot", "'name'"]),
    "name with a line end": ('[robot]\nname = "a\\n"\n' + JOINT, ["robot", "'name'"]),
    "name a keyword": ('[robot]\nname = "int"\n' + JOINT, ["robot", "'name'"]),
    "convention": (ROBOT + 'convention = "dh"\n' + JOINT, ["'convention'", "modified-dh"]),
    "two gravity entries": (ROBOT + "gravity = [0, 0]\n" + JOINT, ["'gravity'"]),
    "gravity nan": (ROBOT + "gravity = [nan, 0, 0]\n" + JOINT, ["'gravity'", "finite"]),
    "gravity boolean": (ROBOT + "gravity = [true, 0, 0]\n" + JOINT, ["'gravity'"]),
    "gravity name": (ROBOT + 'gravity = [0, 0, "h"]\n' + JOINT, ["'gravity'", "'h'"]),
    "sigma boolean": (one("sigma", "true"), ["joint 2", "'sigma'"]),
    "sigma float": (one("sigma", "0.0"), ["joint 2", "'sigma'"]),
    "sigma text": (one("sigma", '"0"'), ["joint 2", "'sigma'"]),
    "sigma 3": (one("sigma", 3), ["joint 2", "'sigma'", "2"]),
    "antecedent itself": (one("antecedent", 2), ["joint 2", "'antecedent'", "0 (the base) to 1"]),
    "antecedent later": (one("antecedent", 3) + JOINT, ["joint 2", "'antecedent'"]),
    "antecedent negative": (one("antecedent", -1), ["joint 2", "'antecedent'"]),
    "antecedent boolean": (one("antecedent", "true"), ["joint 2", "'antecedent'"]),
    "antecedent huge": (one("antecedent", "9" * 25), ["joint 2", "'antecedent'"]),
    "friction is text": (one("friction", '"coulomb"'), ["joint 2", "'friction'"]),
    "friction unknown": (one("friction", '["dry"]'), ["joint 2", "'friction'", "viscous"]),
    "friction twice": (one("friction", '["offset", "offset"]'), ["joint 2", "'friction'"]),
    "width negative": (one("coulomb_width", -1), ["joint 2", "'coulomb_width'"]),
    "width inf": (one("coulomb_width", "inf"), ["joint 2", "'coulomb_width'"]),
    "width boolean": (one("coulomb_width", "true"), ["joint 2", "'coulomb_width'"]),
    "width text": (one("coulomb_width", '"0.1"'), ["joint 2", "'coulomb_width'"]),
    # 1/width overflows a double: the C then says `inf` and does not compile.
    "width denormal": (one("coulomb_width", "1e-320"), ["joint 2", "'coulomb_width'"]),
    "rotor is a number": (one("rotor_inertia", 1), ["joint 2", "'rotor_inertia'"]),
    "rotor is a float": (one("rotor_inertia", "0.0"), ["joint 2", "'rotor_inertia'"]),
    "rotor is text": (one("rotor_inertia", '"false"'), ["joint 2", "'rotor_inertia'"]),
    "fixed with friction": (one("sigma", 2) + 'friction = ["viscous"]\n', ["joint 2", "fixed"]),
    "fixed with rotor": (one("sigma", 2) + "rotor_inertia = true\n", ["joint 2", "fixed"]),
    "all fixed": (ROBOT + JOINT + "sigma = 2\n", ["movable"]),
    "coupling to nothing": (TWO + COUPLING.format(1, 3, 1), ["coupling 1", "'joints'", "3"]),
    "coupling to fixed": (one("sigma", 2) + COUPLING.format(1, 2, 1), ["coupling 1", "2"]),
    "coupling to itself": (TWO + COUPLING.format(1, 1, 1), ["coupling 1", "'joints'"]),
    "coupling to the base": (TWO + COUPLING.format(0, 1, 1), ["coupling 1", "'joints'", "0"]),
    "coupling twice": (TWO + COUPLING.format(1, 2, 1) * 2, ["coupling 2", "'joints'"]),
    "coupling ratio 0": (TWO + COUPLING.format(1, 2, "0.0"), ["coupling 1", "'ratio'"]),
    "coupling of three": (TWO + "[[coupling]]\njoints = [1, 2, 1]\n", ["coupling 1", "'joints'"]),
    "payload nowhere": (TWO + "[payload]\njoint = 9\n", ["payload", "'joint'", "9"]),
    "payload on the base": (TWO + "[payload]\njoint = 0\n", ["payload", "'joint'"]),
    "limits of one joint": (TWO + "[limits]\nvelocity = [1]\n", ["limits", "'velocity'", "2"]),
    "limits negative": (TWO + "[limits]\nvelocity = [1, -1]\n", ["limits", "'velocity'"]),
    "limits infinite": (TWO + "[limits]\ntorque = [inf, 1]\n", ["limits", "'torque'"]),
    "limits empty": (TWO + "[limits]\nposition = [[0, 1], [1, 1]]\n", ["limits", "'position'"]),
    "201 joints": (ROBOT + JOINT * 201, ["joint", "200"]),
    "d nan": (one("d", "nan"), ["joint 2", "'d'", "finite"]),
    "d inf": (one("d", "-inf"), ["joint 2", "'d'", "finite"]),
    "d boolean": (one("d", "true"), ["joint 2", "'d'", "a number or an expression"]),
    "d list": (one("d", "[1]"), ["joint 2", "'d'", "a number or an expression"]),
    "d fourth root": (one("d", '"sqrt(sqrt(2))"'), ["joint 2", "'d'", "roots of roots"]),
    "d power of a power": (one("d", '"((L1+L2)**4)**8"'), ["joint 2", "'d'", "powers up to"]),
    "d 1e-300": (one("d", "1e-300"), ["joint 2", "'d'", "out of range"]),
    "d date": (one("d", "2020-01-01"), ["joint 2", "'d'"]),
    "d 1e999": (one("d", "1e999"), ["joint 2", "'d'"]),
    # Hangs where the number is turned into an int of 10^8 digits.
    "d 1e99999999": (one("d", "1e99999999"), ["joint 2", "'d'"]),
    "d too long for Decimal": (one("d", "1e" + "9" * 20), ["joint 2", "'d'", "finite"]),
    "drive side a list": (TWO + '[drive]\nside = ["motor"]\n', ["drive", "'side'"]),
    "drive side a table": (TWO + "[drive]\nside = { a = 1 }\n", ["drive", "'side'"]),
    "drive side unknown": (TWO + '[drive]\nside = "x"\n', ["'side'", "'motor' or 'link'"]),
    "d of 4000 digits": (one("d", "1" * 4000), ["joint 2", "'d'"]),
    "d of 100000 digits": (one("d", "0." + "1" * 100_000), ["joint 2", "'d'"]),
    "geometry boolean": (ROBOT + "[geometry]\nL1 = true\n" + JOINT, ["geometry", "'L1'"]),
    "geometry table": (ROBOT + "[geometry.L1]\nx = 1\n" + JOINT, ["geometry", "'L1'"]),
}


@pytest.mark.parametrize("case", FILES)
def test_a_bad_file_is_refused_with_its_place(case):
    text, words = FILES[case]
    refused(text, *words)


EXPRESSIONS = [
    "", "  ", "PI", "L3", '__import__("os")', "().__class__", "L1.real", "lambda: 0",
    "L1 if 1 else 2",
    "9**9**9**9", "10**16**16", "((10**16)**16)**16", "1e999", "1e299**16", "1/0", "1/(1-1)",
    "1/(L1-0.5)", "sqrt(-1)", "sqrt(L1-1)", "(-1)**0.5", "L1**L2", "2**L1", "0**-1", "sin(1)",
    "sqrt(1,2)", "sqrt()", "sqrt", "2L1", "L1 L2", "1.2.3", "1e", "0x10", "1_000", "1j", "\u0661",
    "\u03c0", "\uff2c1", "L1\u00b2", "\u2212L1", "1,5", "(1", "1)", "(" * 60 + "1" + ")" * 60,
    "-" * 60 + "1", "1+" * 600 + "1", "L1;L2", "True", "None", "oo", "nan", "inf", "zoo", "I",
    "2**17",
]  # fmt: skip


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_an_expression_outside_the_grammar_is_refused_at_its_key(expression):
    refused(one("d", quoted(expression)), "joint 2", "'d'")


NAMES = "q q1 qd2 qdd tau3 i1 XX1 ZZ2R IAM2 FS1 pi sqrt sin abs g int while class _L 1L L-1".split()


@pytest.mark.parametrize("name", [*NAMES, '"L 1"', '"L\u00e4"', '""'])
def test_a_name_that_means_something_else_is_refused(name):
    refused(ROBOT + f"[geometry]\n{name} = 1\n" + JOINT)


@pytest.mark.parametrize("name", ["math", "stddef"])
def test_a_robot_is_not_named_like_a_header_of_c(name):
    # math.h of the package would stand in for <math.h>.
    refused(f'[robot]\nname = "{name}"\n' + JOINT, "'name'")


def test_a_name_too_long_for_a_file_is_refused():
    refused(f'[robot]\nname = "{"a" * 300}"\n' + JOINT, "'name'")


def test_a_coupling_ratio_whose_value_is_zero_is_refused():
    refused(ROBOT + GEOMETRY + JOINT + JOINT + COUPLING.format(1, 2, '"L1-0.5"'), "'ratio'")


def test_a_byte_order_mark_is_read_or_named():
    try:
        assert symgen.parse_robot("\ufeff" + TWO, "file.toml").n == 2
    except RobotError as error:
        assert "byte order mark" in str(error)


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", TWO.encode("utf-16"), b"\x80"])
def test_a_file_that_is_not_utf8_is_refused(tmp_path, content):
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises(RobotError, match="UTF-8"):
        symgen.read_robot(tmp_path / "a.toml")


def test_a_folder_without_a_robot_is_refused(tmp_path):
    with pytest.raises(RobotError, match=r"a folder without a robot\.toml; accepted"):
        symgen.read_robot(tmp_path)


def test_a_file_of_many_megabytes_is_refused(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"#" * 3_000_000)
    with pytest.raises(RobotError, match="bytes"):
        symgen.read_robot(tmp_path / "a.toml")


@pytest.mark.parametrize("source", ["a" * 5000, "a\0b"])
def test_a_path_that_no_file_can_have_is_refused(source):
    with pytest.raises(RobotError):
        symgen.read_robot(source)


# Odd robots that are valid: energies and counts against the independent oracle.


def arm_of(robot):
    values = robot.values()

    def column(key):
        return tuple(float(getattr(j, key).subs(values).evalf(30)) for j in robot.joints)

    return Arm(
        sigma=tuple(j.sigma for j in robot.joints),
        ant=tuple(j.antecedent for j in robot.joints),
        gravity=tuple(float(g.subs(values).evalf(30)) for g in robot.gravity),
        **{key: column(key) for key in ("gamma", "b", "alpha", "d", "theta", "r")},
    )


def standard_columns(robot, arm, q, qd):
    """Return the oracle's columns with those of couplings, payload and offsets, and their names."""
    rotor = [j.rotor_inertia for j in robot.joints]
    energy = energy_regressor(arm, q, qd, rotor)
    columns = dict(zip(column_names(arm, rotor), energy.T, strict=True))
    at = {j: i for i, j in enumerate(arm.movable)}
    if robot.payload is not None:
        links = [n for n in columns if n.strip("XYZMIA") == str(robot.payload) and n[0] != "I"]
        columns |= {n.rstrip("0123456789") + "L": columns[n] for n in links}
    for c in robot.couplings:
        u = qd[:, at[c.first]] + float(c.ratio.subs(robot.values())) * qd[:, at[c.second]]
        columns[f"IAM{c.second}"] = u * u / 2
    columns |= {
        f"OF{j.number}": q[:, at[j.number]] for j in robot.movable if "offset" in j.friction
    }
    return columns


def assert_right(text):
    """Compare count, regrouping formulas and energies of a valid robot with the oracle."""
    robot = symgen.parse_robot(text, "file.toml")
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot
    with within(15):
        model = symgen.derive(robot)
        evaluator = symgen.load(model, backend="casadi")
    arm = arm_of(robot)
    draw = np.random.default_rng(5)
    q, qd = draw.uniform(-2, 2, (2, 24 * arm.links + 60, arm.n))
    columns = standard_columns(robot, arm, q, qd)
    matrix = np.column_stack(list(columns.values()))
    kept = [p for p in model.base.parameters if p.inertial or p.head.startswith("OF")]
    assert len(kept) == numeric_rank(matrix[1:] - matrix[0])
    X = dict(zip(columns, draw.uniform(-1, 1, len(columns)), strict=True))
    words = X | {n: float(v) for n, v in robot.geometry}
    words |= {"sqrt": math.sqrt, "cos": math.cos, "sin": math.sin, "pi": math.pi}
    base = [float(eval(p.expression, {}, words)) for p in kept]
    offsets = [(p, b) for p, b in zip(kept, base, strict=True) if not p.inertial]
    h = evaluator.energy_regressor(q, qd) @ np.array(base[: model.inertial])
    h += sum(b * columns[p.head] for p, b in offsets)
    exact = np.column_stack(list(columns.values())) @ np.array(list(X.values()))
    size = max(np.abs(exact).max(), 1e-300)
    np.testing.assert_allclose(h - h[0], exact - exact[0], rtol=0, atol=1e-11 * size)


def three(geometry, d2='"L1"', alpha2='"pi/2"', d3='"L2"', alpha3="0", gravity=None, more=""):
    head = ROBOT + (f"gravity = {gravity}\n" if gravity else "")
    names = "[geometry]\n" + "".join(f"{k} = {v}\n" for k, v in geometry.items())
    joints = f"{JOINT}{JOINT}d = {d2}\nalpha = {alpha2}\n{JOINT}d = {d3}\nalpha = {alpha3}\n"
    return head + (names if geometry else "") + joints + more


def chain(*joints, gravity="[0, 0, -9.81]", more=""):
    return ROBOT + f"gravity = {gravity}\n" + "".join(JOINT + j + "\n" for j in joints) + more


G = {"L1": 0.5, "L2": 0.3}
OFFSET = 'friction = ["offset"]'
SIX = (
    "", 'alpha = "-pi/2"', "d = 0.5\nr = 0.15", 'd = -0.02\nr = 0.3\nalpha = "pi/2"',
    'alpha = "-pi/2"', 'alpha = "pi/2"',
)  # fmt: skip
ODD = {
    "one joint": chain(""),
    "one bare prismatic joint without gravity": chain(
        "sigma = 1\nrotor_inertia = false\nfriction = []", gravity="[0, 0, 0]"
    ),
    "fixed first": chain('sigma = 2\nd = 0.3\nalpha = "pi/2"', "d = 0.3"),
    "fixed between": chain("", 'sigma = 2\nalpha = "pi/3"\ntheta = 0.3\nd = 0.2', "alpha = 0.4"),
    "fixed last": chain("", 'alpha = "pi/2"', "sigma = 2\nd = 0.3\nalpha = 0.3"),
    # Square roots: of primes other than 2 and 3 a fixed prime has none in half of the cases.
    "sqrt of numbers": three({}, '"sqrt(0.41)"', d3='"sqrt(0.2)"'),
    "sqrt(5)": three(G, '"sqrt(3)*L1/2"', d3='"sqrt(5)*L2"'),
    "sqrt(2) + sqrt(3)": three(G, '"sqrt(2)+sqrt(3)"'),
    "sqrt of sums of named lengths": three(G, '"sqrt(L1**2+L2**2)"'),
    "sqrt of a named length": three(G, '"sqrt(L1)"', d3='"sqrt(L2)"'),
    "sqrt of a square": three(G, '"sqrt(L1**2)"'),
    "sqrt of the square of a negative": three({"L1": -0.5, "L2": 0.3}, '"sqrt(L1**2)"'),
    "one over a sqrt": three(G, '"1/sqrt(L1+L2)"'),
    "one over a sum": three(G, '"1/(L1+L2)"'),
    "a high power": three(G, '"(L1+L2)**16"'),
    "pi in a length": three(G, '"pi*L1"', '"pi/7"', alpha3='"2*pi/7"'),
    "sqrt(2) as an angle": three(G, alpha2='"sqrt(2)"', alpha3='"2*sqrt(2)"'),
    "sqrt of a length as an angle": three(G, alpha2='"sqrt(L1)"', alpha3='"sqrt(2)*L1/2"'),
    "commensurable angles": three(G, alpha2="0.3", alpha3="0.6"),
    "opposite angles": three(G, alpha2="0.3", alpha3="-0.3"),
    "a named angle and fractions of it": three({**G, "A": 0.3}, alpha2='"A/2"', alpha3='"-A/3"'),
    "a named angle plus a seventh": three({**G, "A": 0.3}, alpha2='"A+pi/7"', alpha3='"A"'),
    "a named angle of a quarter turn": three({**G, "A": '"pi/2"'}, alpha2='"A"', alpha3='"A"'),
    "a named angle of zero": three({**G, "A": 0}, alpha2='"A"', alpha3='"A"'),
    "one symbol as length and angle": three(G, alpha2='"L1"', alpha3='"L2"'),
    "a product of symbols as an angle": three({**G, "A": 0.2}, alpha2='"A*L1"', alpha3='"1/A"'),
    "pi times a symbol as an angle": three(G, alpha2='"pi*L1"'),
    # The file's values decide the minimal set.
    "named lengths of zero": three({"L1": 0, "L2": 0}),
    "one named length of zero": three({"L1": 0, "L2": 0.3}, alpha3='"pi/3"'),
    "a difference of equal lengths": three({"L1": 0.3, "L2": 0.3}, '"L1-L2"'),
    "sqrt of a difference that is zero": three({"L1": 0.3, "L2": 0.3}, '"sqrt(L1-L2)"'),
    "a length of 1e-12": three({"L1": "1e-12", "L2": 0.3}),
    "names that differ by case": three({"L1": 0.5, "l1": 0.3}, d3='"l1"'),
    "names of steps": three({"W32": 0.5, "C2": 0.3, "V31": 0.2}, '"W32+V31"', d3='"C2*V31"'),
    "names of columns": three({"DXX2": 0.5, "H2": 0.3, "R1": 2}, '"DXX2*R1"', d3='"H2"'),
    "names of constants": three({"d2": 0.5, "gx": 0.3, "Calpha2": 2}, '"gx"', d3='"Calpha2*d2"'),
    "names of arguments": three({"out": 0.5, "N": 0.3, "k": 2}, '"out*k"', d3='"N"'),
    "no gravity": three(G, gravity="[0, 0, 0]"),
    "symbolic gravity": three({**G, "gz": -9.81}, gravity='[0, 0, "gz"]'),
    "symbolic gravity of zero": three({**G, "gz": 0}, gravity='[0, 0, "gz"]'),
    "tilted symbolic gravity": three({**G, "h": 9.81, "A": 0.1}, gravity='["h*A", 0, "-h"]'),
    "gravity in radicals": three(G, gravity='["-9.81*sqrt(2)/2", 0, "-9.81*sqrt(2)/2"]'),
    "offset on a vertical axis": chain(f"sigma = 1\n{OFFSET}", OFFSET, f"sigma = 1\n{OFFSET}"),
    "offset on tilted axes": chain(
        f"sigma = 1\nalpha = 0.3\n{OFFSET}", f"sigma = 1\nalpha = 0.5\n{OFFSET}", OFFSET
    ),
    "two trees on the base": chain("", "d = 0.5", 'antecedent = 0\ngamma = 0.4\nalpha = "pi/2"'),
    "branches": chain(
        "", 'alpha = "pi/2"', "antecedent = 1\ngamma = 0.5\nb = 0.2\nalpha = 0.3\nd = 0.5",
        'antecedent = 1\ngamma = "pi/3"\nd = 0.3', "antecedent = 2\nsigma = 1\nr = 0.4",
    ),
    "coupling": chain(*SIX, more=COUPLING.format(5, 6, 1)),
    "coupling to a base joint": chain(*SIX, more=COUPLING.format(2, 3, -1)),
    "coupling in radicals": chain(*SIX, more=COUPLING.format(2, 3, '"sqrt(2)"')),
    "coupling and payload": chain(
        *SIX, more=COUPLING.format(5, 6, 1) + "[payload]\njoint = 6\n"
    ),
    "payload on a fixed link": chain(
        "", 'alpha = "pi/2"', "sigma = 2\nd = 0.5", more="[payload]\njoint = 3\n"
    ),
    "a width": chain("coulomb_width = 0.1", "d = 0.5\ncoulomb_width = 1e-6"),
    "ten joints": chain(*['alpha = "pi/2"\nd = 0.1\nr = 0.2'] * 10),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::symgen.errors.SymgenWarning")
@pytest.mark.parametrize("case", ODD)
def test_an_odd_robot_has_the_energy_and_the_count_of_the_oracle(case):
    assert_right(ODD[case])


@pytest.mark.parametrize(
    "angle", ["pi/5", "pi/7", "pi/8", "pi/10", "pi/12", "pi/15", "pi/16", "pi/24", "5*pi/24",
              "11*pi/24", "37.5*pi/180", "pi/180"],
)  # fmt: skip
def test_any_fraction_of_pi_is_derived(angle):
    assert_right(three(G, alpha2=f'"{angle}"', alpha3=f'"-{angle}"'))


def test_an_angle_that_cannot_be_derived_is_named():
    text = one("alpha", '"pi/1000003"')
    with pytest.raises(SymgenError) as caught:
        symgen.derive(symgen.parse_robot(text, "file.toml"))
    assert "joint 2" in str(caught.value)
    assert "accepted" in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["d = 0.1", 'alpha = "pi/2"\nd = 0.1\nr = 0.2'])
def test_forty_joints_are_derived_in_seconds(joint):
    with within(120):
        model = symgen.derive(symgen.parse_robot(chain(*[joint] * 40)))
    assert len(model.base.parameters) > 100


def test_couplings_both_ways_on_one_pair_are_refused():
    # Their friction columns would depend on those of the joints: no minimal set.
    both = COUPLING.format(1, 2, 2) + COUPLING.format(2, 1, 0.5)
    with pytest.raises(symgen.RobotError, match=r"coupling 2, key 'joints'"):
        symgen.parse_robot(chain(*SIX, more=both))

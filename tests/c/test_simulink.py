"""The target simulink: what NAME_simulink asks of Simulink, recorded in Octave by stand-ins."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from packages import run

import symgen
from symgen.codegen.values import Values

pytestmark = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in ("octave", "cc")),
    reason="octave or cc is not on this machine",
)
#: Each prints its arguments as one line of JSON. Ports of a block are those of the function's
#: prototype, which the test has read from NAME.h.
RECORDING = """function {name}(varargin)
  disp(jsonencode([{{'{name}'}}, varargin]));
end
"""
STAND_INS = ("load_system", "close_system", "new_system", "add_block", "save_system")
OTHERS = {
    "set_param": """function set_param(block, varargin)
  global names
  disp(jsonencode([{'set_param'}, {block}, varargin]));
  if strcmp(varargin{1}, 'FunctionName')
    names.(strrep(block, '/', '_')) = varargin{2};
  end
end
""",
    "get_param": """function ports = get_param(block, key)
  global names made
  called = names.(strrep(block, '/', '_'));
  words = jsondecode(fileread('arguments.json')).(called);
  ports = Ports(cellfun(@(n) struct('Name', n, 'Scope', 'Input'), words));
  made{end + 1} = {called, ports};
end
""",
    "Ports": """classdef Ports < handle
  properties
    InputArguments
  end
  methods
    function self = Ports(words)
      self.InputArguments = words;
    end
  end
end
""",
    "bdIsLoaded": "function loaded = bdIsLoaded(name)\n  loaded = true;\nend\n",
}
SCRIPT = """
addpath('stand_ins'); addpath('{package}');
global names made
names = struct(); made = {{}};
{call}
for i = 1:numel(made)
  for a = made{{i}}{{2}}.InputArguments(:)'
    disp(jsonencode({{'scope', made{{i}}{{1}}, a.Name, a.Scope}}));
  end
end
"""


@pytest.fixture(scope="module", params=["double", "float"])
def package(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A package with values, in a folder whose name has a space."""
    model = symgen.derive(symgen.read_robot("planar2r"), "all")
    values = Values((3.5, 0.06, 0.124, 1e-5), (None,) * 4)
    tree = symgen.generate(
        model, target="simulink", dtype=request.param, prefix="arm", values=values
    )
    folder = tmp_path_factory.mktemp("simulink") / "the arm"
    symgen.write_package(tree, folder)
    return folder


def prototypes(package: Path) -> dict[str, list[str]]:
    """The arguments of each function of one sample, as NAME.h declares them."""
    text = re.sub(r"/\*.*?\*/", "", (package / "arm.h").read_text(), flags=re.S)
    found = re.findall(r"(?:void|int) (arm_\w+)\(([^)]*)\);", text)
    return {
        name: inside.split(",")
        for name, inside in found
        if not name.endswith("_batch") and inside != "void"
    }


def argument(word: str) -> str:
    """The name in the declaration of an argument."""
    return re.sub(r"\[.*", "", word).split()[-1].lstrip("*")


def recorded(package: Path, call: str, folder: Path) -> list[list[Any]]:
    """The calls of NAME_simulink, and the scope of each port after it."""
    (folder / "stand_ins").mkdir()
    texts = OTHERS | {name: RECORDING.format(name=name) for name in STAND_INS}
    for name, text in texts.items():
        (folder / "stand_ins" / f"{name}.m").write_text(text)
    named = {name: list(map(argument, words)) for name, words in prototypes(package).items()}
    (folder / "arguments.json").write_text(json.dumps(named))
    (folder / "script.m").write_text(SCRIPT.format(package=package, call=call))
    octave = ["octave", "--no-gui", "--norc", "--quiet", "script.m"]
    printed = run(octave, folder)
    return [json.loads(line) for line in printed.splitlines()]


def settings(calls: list[list[Any]], model: str) -> dict[str, str]:
    """The parameters that were set of a model."""
    return {c[2]: c[3] for c in calls if c[:2] == ["set_param", model]}


def check_sources(package: Path, chosen: dict[str, str], folder: Path) -> None:
    """Check that the custom code has every function, and links without other files."""
    assert chosen["SimCustomHeaderCode"] == '#include "arm.h"'
    assert chosen["SimUserIncludeDirs"] == f'"{package}"'
    sources = [package / name for name in chosen["SimUserSources"].split("\n")]
    assert all(source.is_file() for source in sources)
    (folder / "all.c").write_text(
        f"{chosen['SimCustomHeaderCode']}\nvoid (*all[])(void) = {{\n"
        + "".join(f"    (void (*)(void)){name},\n" for name in prototypes(package))
        + "};\n"
    )
    build = ["cc", "-shared", "-fPIC", "-Wl,--no-undefined", f"-I{package}", "all.c", *sources]
    run([*build, "-lm", "-o", "all.so"], folder)


def test_the_library_has_a_block_for_each_function(package: Path, tmp_path: Path) -> None:
    calls = recorded(package, "arm_simulink();", tmp_path)
    order = [c[0] for c in calls if c[0] not in ("set_param", "add_block", "scope")]
    assert order == ["load_system", "close_system", "new_system", "save_system"]
    assert calls[2][1:] == ["arm_blocks", "Library"]
    check_sources(package, settings(calls, "arm_blocks"), tmp_path)
    assert settings(calls, "arm_blocks")["SimUseLocalCustomCode"] == "on"
    blocks = {c[2]: c for c in calls if c[0] == "add_block"}
    constant = blocks.pop("arm_blocks/X")
    functions = prototypes(package)
    assert set(blocks) == {f"arm_blocks/{name.removeprefix('arm_')}" for name in functions}
    assert {c[1] for c in blocks.values()} == {"simulink/User-Defined Functions/C Caller"}
    for block in blocks:
        assert settings(calls, block) == {"FunctionName": block.replace("arm_blocks/", "arm_")}
    places = [tuple(c[4]) for c in (*blocks.values(), constant)]
    assert len(set(places)) == len(places)
    options = dict(zip(constant[3::2], constant[4::2], strict=True))
    assert options["Value"] == "[3.5; 0.06; 0.124; 1e-05; ]"
    kind = "single" if "typedef float" in (package / "arm.h").read_text() else "double"
    assert options["OutDataTypeStr"] == kind


def test_ports_are_outputs_where_the_prototype_has_no_const(package: Path, tmp_path: Path) -> None:
    calls = recorded(package, "arm_simulink();", tmp_path)
    scopes = [c[1:] for c in calls if c[0] == "scope"]
    expected = []
    for function, words in prototypes(package).items():
        for word in words:
            name = argument(word)
            written = "[" in word and "const" not in word
            both = (function, name) == ("arm_add_body", "X")
            scope = "InputOutput" if both else "Output" if written else "Input"
            expected.append([function, name, scope])
    assert scopes == expected


def test_a_model_of_the_user_gets_the_custom_code(package: Path, tmp_path: Path) -> None:
    calls = recorded(package, "arm_simulink('cell');", tmp_path)
    assert {c[0] for c in calls} == {"set_param"}
    chosen = settings(calls, "cell")
    assert chosen["RTWUseSimCustomCode"] == "on"
    check_sources(package, chosen, tmp_path)

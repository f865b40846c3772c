"""Compile C sources into a Python module (cffi, API mode), and cache it by digest.

The cache key is the digest of the sources, the compiler with its version, the flags, and the Python
that loads the module. Each build happens in a separate folder and ends with one atomic rename, so a
killed build leaves no module. Two processes that need a module at once both build it.

Loading a module runs it: `symgen.cache` describes which files it accepts.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from types import ModuleType

from symgen.cache import digest, name_in_cache, private_folder, unchanged
from symgen.errors import BuildError, SymgenWarning
from symgen.parallel import in_order, thread_count

_FLAGS = ("-O2", "-fPIC", "-std=gnu11", "-fno-math-errno", "-ffp-contract=fast")
#: For the wrapper, which only passes pointers on: calls are as fast, and it compiles in half the
#: time.
_WRAPPER = ("-O0",)
_NATIVE = "-march=native"  # all instructions of this processor
_TIMEOUT_SECONDS = 300
_PROBE_SECONDS = 20
_SHOWN = 200  # maximum number of characters of compiler output without an error line
_ONE_LINE = b"int probe(void) { return 1; }\n"
#: Compile to assembler text. With -fsyntax-only, zig would link, and build a C library first.
_ASSEMBLE = ("-S", "-o", "-", "-x", "c", "-")


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its command, and its name and version."""

    command: tuple[str, ...]
    version: str


def find_compiler() -> Compiler | None:
    """Return the C compiler to use, or None.

    It is the first one that works, in this order: the variable SYMGEN_CC ("none" means no
    compiler), the variable CC, cc, gcc, clang, the ziglang wheel (`symgen[cc]`).
    """
    chosen = os.environ.get("SYMGEN_CC", "").strip()
    return _first_working(chosen, os.environ.get("CC", ""), os.environ.get("PATH", ""))


@cache
def _first_working(wanted: str, cc: str, path: str) -> Compiler | None:
    """Return the first working compiler; `path` lists the folders of commands."""
    if wanted == "none":
        return None
    commands = [wanted] if wanted else [cc, "cc", "gcc", "clang"]
    candidates = [tuple(command.split()) for command in commands if command]
    if not wanted and importlib.util.find_spec("ziglang") is not None:
        candidates.append((sys.executable, "-m", "ziglang", "cc"))
    for command in candidates:
        if shutil.which(command[0], path=path or None) is None:
            continue
        status, said = _probe((*command, "--version"))
        if status == 0:
            return Compiler(command, said.strip().partition("\n")[0])
        if status is None:
            warnings.warn(_silent(command), SymgenWarning, stacklevel=2)
    return None


@cache
def _probe(command: tuple[str, ...]) -> tuple[int | None, str]:
    """Return exit status and output of a trivial compilation; None without an answer in time."""
    try:
        done = subprocess.run(command, input=_ONE_LINE, capture_output=True, timeout=_PROBE_SECONDS)
    except subprocess.TimeoutExpired:
        return None, ""
    except OSError:
        return 127, ""
    return done.returncode, done.stdout.decode("utf-8", "replace")


def _silent(command: tuple[str, ...]) -> str:
    return (
        f"{' '.join(command)} does not compile a probe of one line in {_PROBE_SECONDS:g} s and is "
        "not used; SYMGEN_CC chooses another compiler"
    )


@cache
def native(compiler: Compiler) -> str:
    """Return the compiler's predefined macros for this machine's processor, one a line.

    They name every instruction set. A cache on a shared disk therefore never gives a module to a
    processor that cannot run it.
    """
    probe = (*compiler.command, *_FLAGS, _NATIVE, "-dM", "-E", "-x", "c", os.devnull)
    status, said = _probe(probe)
    return "\n".join(sorted(said.splitlines())) if status == 0 else ""


def missing_compiler() -> str:
    """Return a text with the reason why there is no compiler, and how to install one."""
    wanted = os.environ.get("SYMGEN_CC", "").strip()
    tried = f"SYMGEN_CC is {wanted}" if wanted else "cc, gcc, clang"
    return f"no C compiler was found ({tried}); pip install 'symgen[cc]' brings one"


def build_module(
    sources: Mapping[str, bytes],
    declarations: str,
    compiler: Compiler,
    flags: Sequence[str] = (),
) -> ModuleType:
    """Compile C sources into a cffi module, or load it from the cache.

    Args:
        sources: name and content of every .c and .h file.
        declarations: the functions that Python uses, in the syntax of cffi.
        compiler: the compiler, from `find_compiler`.
        flags: flags for this machine's processor, in addition to those of every build.

    Returns:
        The module, with `ffi` and `lib`.

    Raises:
        BuildError: the compiler fails, or the result cannot be loaded.
    """
    import cffi

    suffix = sysconfig.get_config_var("EXT_SUFFIX") or ".so"
    built_by = (*compiler.command, compiler.version, *_FLAGS, *_WRAPPER, *flags, native(compiler))
    names = sorted(sources)
    key = digest(
        *built_by, cffi.__version__, suffix, declarations, *names, *map(sources.__getitem__, names)
    )
    module = f"_symgen_{key[:32]}"
    folder = private_folder()
    if found := unchanged(folder, module, suffix):
        try:
            return _load(module, found)
        except ImportError:  # built on another computer, for example: build it again
            found.unlink(missing_ok=True)
    if _probe((*compiler.command, *_ASSEMBLE))[0] is None:
        raise BuildError(_silent(compiler.command))
    try:
        with tempfile.TemporaryDirectory(prefix="build-", dir=folder) as work:
            built = _compile(module, sources, declarations, compiler, flags, Path(work), suffix)
            built.chmod(0o700)
            target = folder / name_in_cache(module, built.read_bytes(), suffix)
            os.replace(built, target)
    except OSError as error:
        raise BuildError(
            f"{folder}: the compiled model cannot be kept: {error.strerror}"
        ) from error
    try:
        return _load(module, target)
    except ImportError as error:
        raise BuildError(f"the compiled model cannot be loaded: {error}") from error


def _compile(
    module: str,
    sources: Mapping[str, bytes],
    declarations: str,
    compiler: Compiler,
    flags: Sequence[str],
    work: Path,
    suffix: str,
) -> Path:
    """Compile the sources and the wrapper in a folder, in parallel, and link them."""
    import cffi
    from cffi import recompiler

    ffi = cffi.FFI()
    ffi.cdef(declarations)
    headers = sorted(name for name in sources if name.endswith(".h"))
    preamble = "".join(f'#include "{h}"\n' for h in headers)
    recompiler.make_c_source(ffi, module, preamble, str(work / f"{module}.c"))
    include = sysconfig.get_path("include")
    if not (Path(include) / "Python.h").is_file():
        raise BuildError(f"{include}/Python.h is missing: install the headers of this Python")
    command = (*compiler.command, *_FLAGS)
    commands = [(*command, *_WRAPPER, f"-I{include}", "-c", f"{module}.c")]
    commands += [(*command, *flags, "-c", file) for file in unpacked(sources, work)]
    for _ in in_order(partial(_run, work), commands, thread_count()):
        pass
    objects = [f"{Path(command[-1]).stem}.o" for command in commands]
    built = work / f"{module}{suffix}"
    link = (*compiler.command, "-shared", *_platform_flags(), *objects, "-o", built.name, "-lm")
    _run(work, link)
    if not built.is_file():
        raise BuildError(f"{compiler.command[0]} failed on the generated C: nothing was built")
    return built


def _run(work: Path, command: Sequence[str]) -> None:
    """Run a compiler in a folder.

    Raises:
        BuildError: the compiler cannot run, or fails; the message has its first error.
    """
    try:
        done = subprocess.run(
            command,
            cwd=work,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=_TIMEOUT_SECONDS,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise BuildError(f"{command[0]} could not be run: {error}") from error
    if done.returncode != 0:
        errors = [line for line in done.stderr.splitlines() if "error" in line]
        first = errors[0] if errors else done.stderr[:_SHOWN]
        reason = " ".join(first.split()) or f"exit status {done.returncode}"
        raise BuildError(f"{command[0]} failed on the generated C: {reason}")


def unpacked(sources: Mapping[str, bytes], folder: Path) -> list[str]:
    """Write sources into a folder; return the names of those to compile."""
    for name, content in sources.items():
        (folder / name).write_bytes(content)
    return sorted(name for name in sources if name.endswith(".c"))


def _platform_flags() -> list[str]:
    if sys.platform == "darwin":
        return ["-undefined", "dynamic_lookup"]
    if sys.platform == "win32":
        version = f"{sys.version_info.major}{sys.version_info.minor}"
        return [f"-L{Path(sys.base_prefix) / 'libs'}", f"-lpython{version}"]
    return []


def _load(name: str, path: Path) -> ModuleType:
    loader = importlib.machinery.ExtensionFileLoader(name, str(path))
    spec = importlib.util.spec_from_file_location(name, path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module

"""From C sources to a loaded module: cffi API mode, cached by digest.

The cache key is the digest of the sources, the compiler with its version, the flags and the Python
that loads the module. A build happens in a folder of its own and ends in one atomic rename, so that
two processes may build at once and a killed build leaves nothing that could be taken for a module.
"""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType

from symgen.errors import BuildError

_FLAGS = ("-O2", "-fPIC", "-shared", "-std=gnu11", "-fno-math-errno", "-ffp-contract=fast")
_NATIVE = "-march=native"  # all that this machine's processor has
_STALE_SECONDS = 3600
_TIMEOUT_SECONDS = 300


@dataclass(frozen=True)
class Compiler:
    """A C compiler: the command, and what it calls itself."""

    command: tuple[str, ...]
    version: str


def find_compiler(wanted: str | None = None) -> Compiler | None:
    """Return the C compiler to use, or None.

    In this order: `wanted` (or the variable SYMGEN_CC; "none" stands for no compiler), the variable
    CC, cc, gcc, clang, and the ziglang wheel (`pip install symgen[cc]`).
    """
    chosen = (wanted or os.environ.get("SYMGEN_CC") or "").strip()
    return _found(chosen, os.environ.get("CC", ""), os.environ.get("PATH", ""))


def forget_compilers() -> None:
    """Look for compilers anew: what was found is remembered for each environment."""
    _found.cache_clear()


@cache
def _found(wanted: str, cc: str, path: str) -> Compiler | None:
    """Return the first compiler that answers; `path` is where commands are looked for."""
    if wanted == "none":
        return None
    candidates: list[tuple[str, ...]] = []
    if wanted:
        candidates.append(tuple(wanted.split()))
    else:
        if cc:
            candidates.append(tuple(cc.split()))
        candidates += [(c,) for c in ("cc", "gcc", "clang")]
        if importlib.util.find_spec("ziglang") is not None:
            candidates.append((sys.executable, "-m", "ziglang", "cc"))
    for command in candidates:
        if shutil.which(command[0], path=path or None) is None:
            continue
        try:
            done = subprocess.run(
                [*command, "--version"], capture_output=True, text=True, timeout=60, check=True
            )
        except (OSError, subprocess.SubprocessError):
            continue
        return Compiler(command, done.stdout.strip().splitlines()[0] if done.stdout else "")
    return None


@cache
def native(compiler: Compiler) -> tuple[tuple[str, ...], str]:
    """Return the flags for this machine's processor, and what tells it from others.

    The macros that the compiler predefines name every instruction set, so that a cache on a shared
    disk never hands a module to a processor that cannot run it.
    """
    command = [*compiler.command, *_FLAGS, _NATIVE, "-dM", "-E", "-x", "c", os.devnull]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    except (OSError, subprocess.SubprocessError):
        return (), ""
    return (_NATIVE,), "\n".join(sorted(done.stdout.splitlines()))


def missing_compiler() -> str:
    """Return in words why there is no compiler, and what brings one."""
    wanted = os.environ.get("SYMGEN_CC", "").strip()
    tried = f"SYMGEN_CC is {wanted}" if wanted else "cc, gcc, clang"
    return f"no C compiler was found ({tried}); pip install 'symgen[cc]' brings one"


def cache_folder() -> Path:
    """Return the folder of compiled models: SYMGEN_CACHE, or the user's cache folder."""
    chosen = os.environ.get("SYMGEN_CACHE")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "symgen"


def build_module(
    sources: Mapping[str, bytes],
    declarations: str,
    compiler: Compiler,
    flags: Sequence[str] = (),
) -> ModuleType:
    """Compile C sources into a cffi module, or load the one that was compiled before.

    Args:
        sources: name and content of every .c and .h file.
        declarations: what Python sees of them, as cffi reads it.
        compiler: from `find_compiler`.
        flags: for this machine's processor, beside those of every build.

    Returns:
        The module, with `ffi` and `lib`.

    Raises:
        BuildError: the compiler fails, or the result cannot be loaded.
    """
    import cffi

    digest = hashlib.sha256()
    suffix = sysconfig.get_config_var("EXT_SUFFIX") or ".so"
    _, processor = native(compiler)
    for part in (
        *compiler.command,
        compiler.version,
        *_FLAGS,
        *flags,
        processor,
        cffi.__version__,
        suffix,
        declarations,
    ):
        digest.update(part.encode() + b"\0")
    for name in sorted(sources):
        digest.update(name.encode() + b"\0" + sources[name] + b"\0")
    module = f"_symgen_{digest.hexdigest()[:32]}"
    folder = _writable(cache_folder())
    for known in sorted(folder.glob(f"{module}-*{suffix}")):
        if _intact(known, suffix):
            try:
                return _load(module, known)
            except ImportError:  # of another machine, say: build it again
                known.unlink(missing_ok=True)
    _sweep(folder)
    work = Path(tempfile.mkdtemp(prefix="build-", dir=folder))
    try:
        built = _compile(module, sources, declarations, compiler, flags, work, suffix)
        target = folder / f"{module}-{_sha256(built)}{suffix}"
        os.replace(built, target)
    except OSError as error:
        raise BuildError(
            f"{folder}: the compiled model cannot be kept: {error.strerror}"
        ) from error
    finally:
        shutil.rmtree(work, ignore_errors=True)
    try:
        return _load(module, target)
    except ImportError as error:
        raise BuildError(f"the compiled model cannot be loaded: {error}") from error


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def _intact(module: Path, suffix: str) -> bool:
    """Whether a cached module is whole: loading a damaged one can kill the interpreter.

    Its name ends in the digest of its content, so that one rename puts both in place.
    """
    try:
        return module.name.removesuffix(suffix).endswith(f"-{_sha256(module)}")
    except OSError:
        return False


def _compile(
    module: str,
    sources: Mapping[str, bytes],
    declarations: str,
    compiler: Compiler,
    flags: Sequence[str],
    work: Path,
    suffix: str,
) -> Path:
    import cffi
    from cffi import recompiler

    for name, content in sources.items():
        (work / name).write_bytes(content)
    ffi = cffi.FFI()
    ffi.cdef(declarations)
    headers = sorted(name for name in sources if name.endswith(".h"))
    preamble = "".join(f'#include "{h}"\n' for h in headers)
    recompiler.make_c_source(ffi, module, preamble, str(work / f"{module}.c"))
    include = sysconfig.get_path("include")
    if not (Path(include) / "Python.h").is_file():
        raise BuildError(f"{include}/Python.h is missing: install the headers of this Python")
    built = work / f"{module}{suffix}"
    files = [f"{module}.c", *sorted(n for n in sources if n.endswith(".c"))]
    command = [
        *compiler.command,
        *_FLAGS,
        *flags,
        *_platform_flags(),
        f"-I{include}",
        *files,
        "-o",
        built.name,
        "-lm",
    ]
    try:
        done = subprocess.run(
            command, cwd=work, capture_output=True, text=True, timeout=_TIMEOUT_SECONDS
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise BuildError(f"{compiler.command[0]} could not be run: {error}") from error
    if done.returncode != 0 or not built.is_file():
        lines = [line for line in done.stderr.splitlines() if "error" in line] or [
            done.stderr[:200]
        ]
        reason = (
            " ".join(lines[0].split()) or f"exit status {done.returncode}, and nothing was built"
        )
        raise BuildError(f"{compiler.command[0]} failed on the generated C: {reason}")
    return built


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


def _writable(folder: Path) -> Path:
    """Return the cache folder, or one of this user's in the temporary folder."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        user = os.environ.get("USER") or os.environ.get("USERNAME") or "user"
        spare = Path(tempfile.gettempdir()) / f"symgen-{user}"
        try:
            spare.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise BuildError(
                f"{folder}: no folder for compiled models: {error.strerror}"
            ) from error
        if hasattr(os, "getuid") and spare.stat().st_uid != os.getuid():
            raise BuildError(f"{spare}: belongs to another user; set SYMGEN_CACHE") from None
        return spare


def _sweep(folder: Path) -> None:
    """Remove what killed builds left behind an hour ago or earlier."""
    for leftover in folder.glob("build-*"):
        try:
            if time.time() - leftover.stat().st_mtime > _STALE_SECONDS:
                shutil.rmtree(leftover, ignore_errors=True)
        except OSError:
            continue

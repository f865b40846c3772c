"""Packages with every kernel, generated once for all tests of this folder, which only read them."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from packages import write


@pytest.fixture(scope="session")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Return the folder of a robot's package with every kernel, in double or float.

    Workers of pytest-xdist share it.
    """
    base = tmp_path_factory.getbasetemp()
    root = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "complete"

    def package(name: str, dtype: str) -> Path:
        folder = root / dtype / name
        if not folder.is_dir():
            folder.parent.mkdir(parents=True, exist_ok=True)
            own = write(name, dtype, tmp_path_factory.mktemp("complete") / name, "all")
            with suppress(OSError):  # another worker was first
                own.rename(folder)
        return folder

    return package

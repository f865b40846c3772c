"""Packages with every kernel, generated once for all tests of this folder, which only read them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from packages import write


@pytest.fixture(scope="session")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Return the folder of a robot's package with every kernel, in double or float."""
    root = tmp_path_factory.mktemp("complete")

    def package(name: str, dtype: str) -> Path:
        folder = root / dtype / name
        return folder if folder.is_dir() else write(name, dtype, folder, "all")

    return package

"""Files at URLs, through fsspec."""

from __future__ import annotations

import glob
from typing import Any
from urllib.parse import urlsplit

from symgen.data.raw import readable, refuse

#: Accepted schemes. Other schemes of fsspec unpack archives, run commands or call services.
SCHEMES = ("file", "s3", "gs", "az", "http", "https", "memory")
_WITHOUT_HOST = ("file", "memory")
_ACCEPTED = f"{', '.join(SCHEMES)}, such as s3://bucket/logs/*.parquet"


def is_remote(source: str) -> bool:
    """Return whether a source is a URL."""
    return "://" in source


def remote_files(url: str) -> list[str]:
    """Return the URLs of all files at a URL of a folder, a pattern, or a file.

    Raises:
        LogError: the URL is not accepted, or cannot be listed.
    """
    system, path = _file_system(url)
    if glob.has_magic(path):
        found = system.glob(path)
    else:
        found = system.find(path) if system.isdir(path) else [path]
    return [str(system.unstrip_protocol(name)) for name in found]


def open_remote(url: str) -> Any:
    """Open the file at a URL.

    Raises:
        LogError: it cannot be opened.
    """
    with readable("cannot be read", _ACCEPTED):
        system, path = _file_system(url)
        return system.open(path, "rb")


def _file_system(url: str) -> tuple[Any, str]:
    scheme = url.partition("://")[0]
    if scheme not in SCHEMES or "::" in url:  # fsspec reads one URL inside another
        refuse("is no URL that is read", _ACCEPTED)
    if scheme not in _WITHOUT_HOST and not urlsplit(url).netloc:
        refuse("names no host or bucket", _ACCEPTED)
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        refuse("URLs need fsspec", "pip install symgen[dask]")
    system, path = url_to_fs(url)
    return system, str(path)

"""Workers in processes of their own, one of them killed; logs at a URL."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from support_streams import motion, parquet, robot

import symgen
from symgen import distributed
from symgen.estimation import chunks
from symgen.identification import out_of_core

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("default")  # of Dask's own


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of two logs that make a dozen partitions."""
    cut = partial(chunks.partitions, chunk=700, most=700)
    monkeypatch.setattr(out_of_core, "partitions", cut)
    for k, name in enumerate("ab"):
        parquet(tmp_path / f"{name}.parquet", motion(4000, k + 1))
    return tmp_path


def test_a_killed_worker_loses_nothing_and_counts_nothing_twice(
    logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    alone = symgen.identify(robot(), str(logs), model="momentum", cutoff=5.0)
    killed: list[int] = []
    results = distributed.OnDask.results

    def kills(self, task, items) -> Iterator:
        for found in results(self, task, items):
            yield found
            if not killed:
                pids = list(self._client.run(os.getpid).values())
                assert len(pids) == 2
                assert os.getpid() not in pids
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

    monkeypatch.setattr(distributed.OnDask, "results", kills)
    work = tmp_path / "work"
    spread = symgen.identify(
        robot(),
        str(logs / "*.parquet"),
        model="momentum",
        cutoff=5.0,
        workers=symgen.Workers(2, work=work),
    )
    assert killed
    assert pytest.approx(alone.X, rel=1e-12) == spread.X
    std, own = ([p.std for p in e.parameters] for e in (spread, alone))
    assert std == pytest.approx(own, rel=1e-12)
    assert spread.torque_validation.relative == pytest.approx(
        alone.torque_validation.relative, rel=1e-12
    )
    assert not list(work.glob(".part-*"))


def _of_worker(name: str) -> bytes:
    return os.environ.get(name, "").encode()


def _loads(folder: Path) -> None:
    (folder / f"{os.getpid()}").touch()


def _loaded(folder: Path) -> bytes:
    return b"yes" if (folder / f"{os.getpid()}").exists() else b""


def test_every_worker_is_prepared_before_it_has_items_and_keeps_the_memory_it_frees(
    tmp_path: Path,
) -> None:
    with distributed.executor(distributed.Workers(2)) as by:
        by.prepare(partial(_loads, tmp_path))
        found = list(by.results(_loaded, [tmp_path] * 8))
        said = dict(by.results(_of_worker, ["MALLOC_TRIM_THRESHOLD_", "OPENBLAS_NUM_THREADS"]))
    # Under Dask's own setting every array would be taken from the system page by page.
    assert said == {0: b"", 1: b"1"}
    assert [content for _, content in found] == [b"yes"] * 8
    assert len(list(tmp_path.iterdir())) == 2


class _Ranges(BaseHTTPRequestHandler):
    """A server of files that knows ranges of bytes, as object stores do."""

    folder: Path

    def do_HEAD(self) -> None:
        self._answer(body=False)

    def do_GET(self) -> None:
        self._answer(body=True)

    def _answer(self, body: bool) -> None:
        path = self.folder / self.path.strip("/")
        if not path.is_file():
            self.send_error(404)
            return
        content = path.read_bytes()
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        part, status = content, 200
        if asked:
            first, last = int(asked[1]), int(asked[2] or len(content) - 1)
            part, status = content[first : last + 1], 206
        self.send_response(status)
        self.send_header("Accept-Ranges", "bytes")
        self.send_header("Content-Length", str(len(part)))
        if asked:
            end = int(asked[1]) + len(part) - 1
            self.send_header("Content-Range", f"bytes {asked[1]}-{end}/{len(content)}")
        self.end_headers()
        if body:
            self.wfile.write(part)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


def test_logs_behind_a_web_server(logs: Path) -> None:
    pytest.importorskip("aiohttp")
    handler = type("Handler", (_Ranges,), {"folder": logs})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        base = f"http://127.0.0.1:{server.server_port}"
        urls = [f"{base}/{name}.parquet" for name in "ab"]
        found = symgen.identify(robot(), urls, model="momentum", cutoff=5.0)
        with pytest.raises(symgen.LogError, match="cannot be read"):
            symgen.identify(robot(), f"{base}/none.parquet", model="momentum")
    finally:
        server.shutdown()
        server.server_close()
    own = symgen.identify(robot(), str(logs), model="momentum", cutoff=5.0)
    assert pytest.approx(own.X, rel=1e-12) == found.X


def test_a_scheduler_that_does_not_answer_is_named() -> None:
    with (
        pytest.raises(symgen.SymgenError, match=r"--scheduler tcp://127.0.0.1:9.*; accepted: the"),
        distributed.executor(distributed.Workers(scheduler="tcp://127.0.0.1:9")),
    ):
        pass


def test_an_error_while_workers_prepare_is_all_that_is_said(tmp_path: Path) -> None:
    code = (
        "import time\nfrom functools import partial\nfrom symgen import distributed\n"
        "if __name__ == '__main__':\n"
        "    with distributed.executor(distributed.Workers(2)) as by:\n"
        "        by.prepare(partial(time.sleep, 1.5))\n"
        "        raise ValueError('of a log')\n"
    )
    (tmp_path / "fails.py").write_text(code)
    done = subprocess.run([sys.executable, tmp_path / "fails.py"], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.startswith("Traceback")
    assert done.stderr.endswith("ValueError: of a log\n")

"""The command symgen, and python -m symgen.

Little is imported before `main` runs: until then Ctrl-C is the interpreter's traceback.
"""

from __future__ import annotations

import os
import signal
from types import FrameType


def main() -> None:
    """Run the command line; Ctrl-C while it is being imported is a line, too."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    from symgen.cli import main as run

    try:
        if signal.getsignal(signal.SIGINT) is _leave:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        run()
    except KeyboardInterrupt:  # before it looked for one, or after
        _leave()


def _leave(_number: int = signal.SIGINT, _frame: FrameType | None = None) -> None:
    os.write(2, b"symgen: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()

"""The command symgen, and python -m symgen.

Little is imported before `main` runs, because Ctrl-C would print a traceback until then.
"""

from __future__ import annotations

import os
import signal
from types import FrameType


def main() -> None:
    """Run the command line. Ctrl-C during the imports also prints only one line."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    from symgen.cli import main as run

    try:
        if signal.getsignal(signal.SIGINT) is _leave:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        run()
    except KeyboardInterrupt:  # before or after `main` handles it
        _leave()
    finally:
        import gc

        gc.freeze()  # or Python searches all expressions for cycles at its end, for 0.2 s


def _leave(_number: int = signal.SIGINT, _frame: FrameType | None = None) -> None:
    os.write(2, b"symgen: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()

"""The program ``skyshed``, as the command line runs it."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Runs the program on the words of the command line and returns its exit code."""
    from skyshed import _skyshed

    # The program hears Ctrl-C itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _skyshed.main(["skyshed", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

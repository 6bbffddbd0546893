"""The `rostether` command, also as `python -m rostether`: silent on Ctrl-C from its first moment on."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Run the command line and return its exit code."""
    # While our modules are imported a Ctrl-C would print where that stood; until then it simply ends us.
    at_interrupt = signal.getsignal(signal.SIGINT)
    if at_interrupt is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from rostether.cli.main import main as run

    signal.signal(signal.SIGINT, at_interrupt)
    return run()


if __name__ == "__main__":
    sys.exit(main())

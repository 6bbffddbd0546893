"""The `rostether` command, also as `python -m rostether`: silent on Ctrl-C from its first moment on."""

from __future__ import annotations

import signal
import sys

# While our modules are imported a Ctrl-C would print where that stood; until then it simply ends us. From the
# import on: only the command imports this module, and its starter does more before it calls `main`.
_at_interrupt = signal.getsignal(signal.SIGINT)
if _at_interrupt is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def main() -> int:
    """Run the command line and return its exit code."""
    from rostether.cli.main import main as run

    signal.signal(signal.SIGINT, _at_interrupt)
    return run()


if __name__ == "__main__":
    sys.exit(main())

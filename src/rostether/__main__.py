"""The `rostether` command, and `python -m rostether`: silent on Ctrl-C from the first moment."""

from __future__ import annotations

import sys

try:
    import signal
except KeyboardInterrupt:
    sys.exit(130)


def _end_at_interrupt() -> None:
    """Make Ctrl-C end the process immediately: an exception during imports would be printed, or be lost."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


# This runs at import, because the command's starter script works for a moment before it calls `main`;
# only the command imports this module. Commands handle Ctrl-C from their start (`cli.shell.interrupts`).
_end_at_interrupt()


def main() -> int:
    """Run the command line and return its exit code."""
    from rostether.cli.main import main as run

    code = run()
    _end_at_interrupt()
    return code


if __name__ == "__main__":
    sys.exit(main())

"""`python -m rostether` is the `rostether` command."""

from __future__ import annotations

import sys

from rostether.cli.main import main

if __name__ == "__main__":
    sys.exit(main())

"""An address as a QR code in the terminal, for phones."""

from __future__ import annotations

import io


def qr_code(text: str) -> str:
    """Return a text as a QR code of half-block characters."""
    import segno

    lines = io.StringIO()
    segno.make(text, micro=False, error="l").terminal(lines, compact=True, border=2)
    return lines.getvalue().rstrip("\n")

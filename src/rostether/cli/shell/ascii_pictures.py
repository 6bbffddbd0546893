"""Prints frames, bars and plots in ASCII where the terminal's encoding lacks their characters."""

from __future__ import annotations

import codecs

ERROR_HANDLER = "rostether-ascii"
# The characters of bars by their height, of shades, frames and trees, and what replaces them.
_ASCII = {
    **dict(zip("▁▂▃▄▅▆▇█", "__--==##", strict=True)),
    **dict.fromkeys("░▒▓", ":"),
    **dict.fromkeys("─━═", "-"),
    **dict.fromkeys("│┃┤├", "|"),
    "└": "`",
    "·": ".",
    "…": "...",
    "\u2800": " ",
}


def register() -> None:
    """Make the error handler known to Python's codecs; other characters are escaped."""
    codecs.register_error(ERROR_HANDLER, _replace)


def _replace(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_in_ascii, error.object[error.start : error.end])), error.end


def _in_ascii(character: str) -> str:
    if character in _ASCII:
        return _ASCII[character]
    if "\u2801" <= character <= "\u28ff":
        # A cell of a plot's dots.
        return "*"
    if "\u2500" <= character <= "\u257f":
        return "+"
    return character.encode("ascii", "backslashreplace").decode()

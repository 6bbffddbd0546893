from __future__ import annotations

import pytest

from rostether.cli.shell import ascii_pictures


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("└─ base_link", "`- base_link"),
        ("├─ arm\n│  └─ grip", "|- arm\n|  `- grip"),
        ("████····", "####...."),
        ("▁▃▅▇", "_-=#"),
        ("│\u2800⠉⢠", "| **"),
        ("grün", "gr\\xfcn"),
        ("\U0001f916", "\\U0001f916"),
    ],
)
def test_pictures_in_ascii(text: str, shown: str) -> None:
    ascii_pictures.register()
    assert text.encode("ascii", ascii_pictures.ERROR_HANDLER).decode() == shown


def test_bytes_that_are_not_utf8_are_escaped() -> None:
    ascii_pictures.register()
    raw = b"gr\xfcn".decode("utf-8", "surrogateescape")
    assert raw.encode("ascii", ascii_pictures.ERROR_HANDLER) == b"gr\\udcfcn"

from __future__ import annotations

from docs.page import matching_lines, missing_lines

PRINTED = """\
flash 7,300 of 32,256 bytes  ██████····· 22 %
range: 1.25
[INFO] [1795.5]: ready at /dev/pts/7
md5 992ce8a1687c
"""


def test_numbers_and_bars_may_differ() -> None:
    bars = "flash 13,068 of 32,256 bytes ████·· 41 %"
    expected = (bars, "range: inf", "ready at /dev/pts/3", "md5 0825d95f")
    assert missing_lines(expected, PRINTED) == []
    assert matching_lines(expected, PRINTED) == PRINTED.splitlines()


def test_numbers_may_have_prefixes_for_thousands_and_millions() -> None:
    assert missing_lines(("/arm  746    64",), "/arm   9.9k   2M\n") == []
    assert missing_lines(("746 Hz",), "746 kHz\n") == ["746 Hz"]


def test_lines_with_other_texts_are_missing() -> None:
    assert missing_lines(("range: none", "md5 992ce8a1687c"), PRINTED) == ["range: none", "md5 992ce8a1687c"]
    assert missing_lines(("md5 992ce8a1687c", "range: 1.0"), PRINTED) == ["range: 1.0"]

from __future__ import annotations

from io import BytesIO

import pytest

from rostether.errors import FirmwareError
from rostether.firmware import debug_limits
from rostether.firmware.debug_limits import Budget, lines_are_bounded
from rostether.firmware.elf import ElfFile

# Two opcodes: the shortest header has one length.
START = bytes.fromhex("ffffff00 0500 04 00 ffff0000 01 01 01 fb 0e 02 00")
FOLDERS = bytes.fromhex("01 01 1f 02 00000000 04000000")
FILES = bytes.fromhex("02 01 1f 02 0b 01 00000000 01")
MANY = bytes.fromhex("ffffffffffffffff7f")


def is_bounded(header: bytes) -> bool:
    return lines_are_bounded(BytesIO(b"before" + header), 6)


def test_the_tables_of_compilers_are_bounded() -> None:
    assert is_bounded(START + FOLDERS + FILES)


def test_the_length_of_a_block_is_not_part_of_it() -> None:
    # Two folders, with blocks of three bytes and of one.
    folders = bytes.fromhex("01 01 09 02 03 aabbcc 01 dd")
    assert is_bounded(START + folders + FILES)


@pytest.mark.parametrize("version", [2, 3, 4])
def test_older_versions_have_no_counts(version: int) -> None:
    assert is_bounded(START[:4] + bytes([version, 0]))


@pytest.mark.parametrize(
    "tables",
    [
        b"\x00" + MANY,
        b"\x01\x01\x1f" + MANY + bytes(40),
        b"\x01\x01\x19" + MANY,
        b"\x01\x01\x08" + MANY + b"a\x00b\x00",
        b"\x01\x01\x09" + MANY + MANY,
        FOLDERS + b"\x00" + MANY,
        FOLDERS,
        b"",
        b"\xff" * 40,
    ],
)
def test_tables_beyond_the_file_are_refused(tables: bytes) -> None:
    assert not is_bounded(START + tables)


def test_a_budget_has_a_limit() -> None:
    budget = Budget(3)
    assert budget.spend(3)
    with pytest.raises(FirmwareError, match="damaged or too large; build it again"):
        budget.spend(1)


def test_a_file_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.firmware.elf.MAX_FILE_BYTES", 1 << 20)
    with pytest.raises(FirmwareError, match=r"sketch\.elf is larger than 1 MiB"):
        ElfFile(bytes((1 << 20) + 1), "sketch.elf")


def test_the_header_of_a_line_program_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(debug_limits, "_MAX_HEADER_BYTES", len(START + FOLDERS))
    assert not is_bounded(START + FOLDERS + FILES)

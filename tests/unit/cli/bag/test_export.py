"""`rostether export`, as its users type it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from unit.cli.command_shell import Shell
from unit.recording.bags import write_bag


@pytest.fixture
def bag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "drive.bag")
    return Path("drive.bag")


def test_a_folder_of_tables_a_file_or_stdout(bag: Path, shell: Shell) -> None:
    assert shell.output("export", str(bag)) == (
        "drive_csv/a.csv: 15 rows, 3 columns of /a\ndrive_csv/b.csv: 15 rows, 3 columns of /b\n"
    )
    text = Path("drive_csv/a.csv").read_text()
    assert text.splitlines()[:2] == [
        "time_s,time_ns,data",
        "1700000000.123456789,1700000000123456789,message 0",
    ]
    assert shell.output("export", str(bag), "--topic", "/a", "-o", "-") == text
    shell.output("export", str(bag), "--topic", "a", "--field", "data", "-o", "one.csv")
    assert Path("one.csv").read_text() == text
    shell.output("export", str(bag), "-o", "tables", "--format", "parquet")
    shell.output("export", str(bag), "--topic", "/b", "-o", "b.parquet")
    Path("run.old").mkdir()
    assert "run.old/a.csv: 15 rows" in shell.output("export", str(bag), "-o", "run.old")
    assert Path("b.parquet").read_bytes()[:4] == Path("tables/b.parquet").read_bytes()[:4] == b"PAR1"


def test_what_makes_no_sense_is_told_and_leaves_no_file(bag: Path, shell: Shell) -> None:
    assert "a file can hold only one topic" in shell.failure("export", str(bag), "-o", "-")
    assert "a file can hold only one topic" in shell.failure("export", str(bag), "-o", "all.csv")
    assert "cannot be written to stdout; give a file" in shell.failure(
        "export", str(bag), "--topic", "/a", "-o", "-", "--format", "parquet"
    )
    assert "no topic /c" in shell.failure("export", str(bag), "--topic", "/c")
    assert "is not a bag" in shell.failure("export", __file__)
    assert ".csv or .parquet" in shell.failure("export", str(bag), "--topic", "/a", "-o", "x.txt")
    assert not Path("x.txt").exists()
    assert "cannot create the folder" in shell.failure("export", str(bag), "-o", "drive.bag/x")
    data = bytearray(bag.read_bytes())
    data[data.index(b"size=") + 5] ^= 0xFF
    bag.write_bytes(data)
    assert "instead of" in shell.failure("export", str(bag))
    assert not list(Path("drive_csv").glob("*"))


def test_a_missing_extra_is_told_with_what_to_type(
    bag: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIRTUAL_ENV", sys.prefix)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "lz4.frame", None)
    printed = shell.failure("export", str(bag), "--format", "parquet")
    assert printed.strip().endswith("Parquet is not installed; run: pip install 'rostether[parquet]'")
    printed = shell.failure("bag", "compress", "--lz4", str(bag))
    assert printed.strip().endswith("LZ4 is not installed; run: pip install 'rostether[recording]'")
    assert "15 rows" in shell.output("export", str(bag))

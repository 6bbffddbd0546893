"""`rostether export`, as its users type it."""

from __future__ import annotations

import sys
from datetime import datetime
from pathlib import Path

import pytest

from rostether.msgdef.registry import Registry
from rostether.recording.bag.writer import BagWriter
from rostether.rostime import NS_PER_S
from rostether.serde.store import TypeStore
from unit.cli.command_shell import Shell
from unit.recording.bags import START_NS, connection, write_bag


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


def test_invalid_arguments_are_reported_and_leave_no_file(bag: Path, shell: Shell) -> None:
    assert "a file can hold only one topic" in shell.failure("export", str(bag), "-o", "-")
    assert "a file can hold only one topic" in shell.failure("export", str(bag), "-o", "all.csv")
    assert "only CSV can be written to stdout; give a file" in shell.failure(
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


def test_a_missing_extra_is_reported_with_what_to_type(
    bag: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIRTUAL_ENV", sys.prefix)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "lz4.frame", None)
    printed = shell.failure("export", str(bag), "--format", "parquet")
    assert printed.strip().endswith("Parquet support is not installed; run: pip install 'rostether[parquet]'")
    printed = shell.failure("bag", "compress", "--lz4", str(bag))
    assert printed.strip().endswith("LZ4 is not installed; run: pip install 'rostether[recording]'")
    assert "15 rows" in shell.output("export", str(bag))


def test_pictures_as_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shell: Shell) -> None:
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "drive.bag")
    assert "no topic has the type sensor_msgs/CompressedImage; the recording has " in shell.failure(
        "export", "drive.bag", "--format", "pictures"
    )
    codec = TypeStore(Registry()).codec("sensor_msgs/CompressedImage")
    writer = BagWriter(tmp_path / "seen.bag")
    number = writer.add_connection(
        connection("/sensors/R3/front", Registry().message_type("sensor_msgs/CompressedImage"))
    )
    for step, form in enumerate(("jpeg", "rgb8; png compressed bgr8")):
        writer.write(number, START_NS + step, [codec.encode({"format": form, "data": form.encode()})])
    writer.close()
    shown = shell.output("export", "seen.bag", "--format", "pictures")
    assert shown == "seen_pictures/sensors.R3.front: 2 pictures of /sensors/R3/front\n"
    folder = Path("seen_pictures/sensors.R3.front")
    stem = f"{datetime.fromtimestamp(START_NS // NS_PER_S):%Y-%m-%d-%H-%M-%S}.123456"
    assert sorted(each.name for each in folder.iterdir()) == [f"{stem}.jpg", f"{stem}.png"]
    assert (folder / f"{stem}.jpg").read_bytes() == b"jpeg"
    assert "pictures need a folder" in shell.failure(
        "export", "seen.bag", "--format", "pictures", "-o", "a.csv"
    )

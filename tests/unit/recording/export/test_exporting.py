"""Tables of messages, read back by Python's csv and by pyarrow."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest

from rostether.errors import ConfigError, RecordingError
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.writer import BagWriter
from rostether.recording.decoding import Decoder
from rostether.recording.export.columns import columns_of
from rostether.recording.export.exporting import Export, ExportedTable
from rostether.recording.export.parquet_table import ParquetTable
from rostether.recording.export.picture_table import PICTURE_TYPE, PictureTable
from rostether.recording.export.tables import CsvTable
from rostether.recording.recorded import Connection
from rostether.serde.store import TypeStore
from unit.recording.bags import START_NS

STORE = TypeStore(Registry())
IMU = {
    "header": {"seq": 7, "stamp": {"secs": 5, "nsecs": 20}, "frame_id": 'a "b",c'},
    "linear_acceleration": {"x": 0.1, "y": float("nan"), "z": -9.81},
    "orientation_covariance": [float(n) for n in range(9)],
}
SCAN = {"ranges": [1.0, float("inf"), 2.5], "header": {"frame_id": "laser"}}
STATUS = {"status": [{"level": 1, "name": "a"}, {"level": 2, "name": "b"}]}
MESSAGES: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("/imu", "sensor_msgs/Imu", IMU),
    ("/scan", "sensor_msgs/LaserScan", SCAN),
    ("/diagnostics", "diagnostic_msgs/DiagnosticArray", STATUS),
    ("/image", "sensor_msgs/CompressedImage", {"data": b"\x00\xff\x10", "format": "jpeg"}),
    ("/on", "std_msgs/Bool", {"data": True}),
    ("/scan", "sensor_msgs/LaserScan", {"ranges": [3.0]}),
)


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    path = tmp_path / "a.bag"
    writer = BagWriter(path)
    for index, (topic, name, value) in enumerate(MESSAGES):
        number = writer.add_connection(Connection(topic, STORE.registry.message_type(name)))
        writer.write(number, START_NS + index, [STORE.codec(name).encode(value)])
    writer.close()
    return path


def _csv(bag: Path, topic: str, *fields: str) -> list[dict[str, str]]:
    text = io.StringIO()
    reader = BagReader(bag)
    export = Export(reader, topics=[topic], fields=fields, report=print)
    export.write(lambda table: CsvTable(text, table.columns))
    reader.close()
    return list(csv.DictReader(io.StringIO(text.getvalue())))


def _parquet(bag: Path, folder: Path, topic: str, *fields: str) -> list[dict[str, Any]]:
    reader = BagReader(bag)
    export = Export(reader, topics=[topic], fields=fields, report=print)
    export.write(lambda table: ParquetTable(folder / "t.parquet", table.columns))
    reader.close()
    rows: list[dict[str, Any]] = pyarrow.parquet.read_table(folder / "t.parquet").to_pylist()
    return rows


def test_nested_fields_times_and_fixed_arrays_have_columns(bag: Path, tmp_path: Path) -> None:
    (row,) = _csv(bag, "/imu")
    assert (row["time_s"], row["time_ns"]) == ("1700000000.123456789", str(START_NS))
    assert (row["header.seq"], row["header.frame_id"]) == ("7", 'a "b",c')
    assert (row["header.stamp_s"], row["header.stamp_ns"]) == ("5.00000002", "5000000020")
    assert [row[f"linear_acceleration.{axis}"] for axis in "xyz"] == ["0.1", "nan", "-9.81"]
    assert [row[f"orientation_covariance[{n}]"] for n in range(9)] == [str(float(n)) for n in range(9)]
    (typed,) = _parquet(bag, tmp_path, "/imu")
    assert typed.keys() == row.keys()
    assert (typed["time_ns"], typed["header.stamp_ns"], typed["header.seq"]) == (START_NS, 5_000_000_020, 7)
    assert typed["orientation_covariance[8]"] == 8.0


def test_arrays_of_any_length_are_lists(bag: Path, tmp_path: Path) -> None:
    rows = _csv(bag, "/scan", "ranges")
    assert [json.loads(row["ranges"]) for row in rows] == [[1.0, float("inf"), 2.5], [3.0]]
    typed = _parquet(bag, tmp_path, "/scan", "ranges")
    assert [row["ranges"] for row in typed] == [[1.0, float("inf"), 2.5], [3.0]]
    assert (_csv(bag, "/image")[0]["data"], _parquet(bag, tmp_path, "/image")[0]["data"]) == (
        "AP8Q",
        b"\x00\xff\x10",
    )
    assert (_csv(bag, "/on")[0]["data"], _parquet(bag, tmp_path, "/on")[0]["data"]) == ("true", True)


def test_arrays_of_messages_are_lists_of_records(bag: Path, tmp_path: Path) -> None:
    (row,) = _csv(bag, "/diagnostics", "status")
    assert [(each["level"], each["name"]) for each in json.loads(row["status"])] == [(1, "a"), (2, "b")]
    (typed,) = _parquet(bag, tmp_path, "/diagnostics", "status")
    assert [(each["level"], each["name"]) for each in typed["status"]] == [(1, "a"), (2, "b")]


@pytest.mark.parametrize(
    ("topic", "field", "columns"),
    [
        ("/scan", "ranges[1]", {"ranges[1]": ["inf", ""]}),
        ("/scan", "ranges[:2]", {"ranges[:2]": ["[1.0,Infinity]", "[3.0]"]}),
        ("/diagnostics", "status[*].level", {"status[:].level": ["[1,2]"]}),
        ("/diagnostics", "status[1]/name", {"status[1].name": ["b"]}),
        ("/imu", "linear_*.[xz]", {}),
        ("/imu", "linear_*.z", {"linear_acceleration.z": ["-9.81"]}),
        ("/imu", "*.stamp_ns", {"header.stamp_ns": ["5000000020"]}),
        ("/imu", "header.stamp", {"header.stamp_s": ["5.00000002"], "header.stamp_ns": ["5000000020"]}),
        ("/imu", "linear_acceleration.x", {"linear_acceleration.x": ["0.1"]}),
    ],
)
def test_fields_are_selected_by_path_and_pattern(
    bag: Path, tmp_path: Path, topic: str, field: str, columns: dict[str, list[str]]
) -> None:
    if not columns:
        with pytest.raises(ConfigError, match="no field"):
            _csv(bag, topic, field)
        return
    rows = _csv(bag, topic, field)
    assert {name: [row[name] for row in rows] for name in list(rows[0])[2:]} == columns
    assert set(_parquet(bag, tmp_path, topic, field)[0]) == {"time_s", "time_ns", *columns}


def test_a_path_of_a_nested_message_selects_all_its_fields() -> None:
    names = [
        each.name for each in columns_of(STORE.codec("nav_msgs/Odometry"), ["pose.pose", "child_frame_id"])
    ]
    assert names == [
        *(f"pose.pose.position.{axis}" for axis in "xyz"),
        *(f"pose.pose.orientation.{axis}" for axis in "xyzw"),
        "child_frame_id",
    ]


def test_missing_topics_and_fields_are_reported(bag: Path) -> None:
    with pytest.raises(ConfigError, match="no topic /nothing; the recording has /diagnostics, /image"):
        _csv(bag, "/nothing")
    with pytest.raises(ConfigError, match="has no field 'colour'"):
        _csv(bag, "/imu", "colour")


def test_messages_that_do_not_fit_are_skipped_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    writer = BagWriter(path)
    number = writer.add_connection(Connection("/on", STORE.registry.message_type("std_msgs/Bool")))
    writer.write(number, START_NS, [b"\x01", b"\x01\x02", b"\x00"])
    broken = MessageType("a/B", "0" * 32, "nothing that is a definition")
    writer.write(writer.add_connection(Connection("/broken", broken)), START_NS, [b""])
    writer.close()
    reported: list[str] = []
    export = Export(BagReader(path), report=reported.append)
    texts: dict[str, io.StringIO] = {}

    def create(table: ExportedTable) -> CsvTable:
        texts[table.name] = io.StringIO()
        return CsvTable(texts[table.name], table.columns)

    export.write(create)
    (table,) = export.tables
    assert (table.row_count, table.unfit_count) == (2, 1)
    assert "std_msgs/Bool" in table.why
    assert len(texts["on"].getvalue().splitlines()) == 3
    assert "/broken" in reported[0]
    with pytest.raises(ConfigError, match=r"^no topic can be written$"):
        Export(BagReader(path), topics=("/broken",), report=reported.append)


def test_a_topic_with_two_types_has_two_tables(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    writer = BagWriter(path)
    for name, value in (("std_msgs/Bool", {"data": True}), ("std_msgs/Int32", {"data": 5})):
        number = writer.add_connection(Connection("/arm/x", STORE.registry.message_type(name)))
        writer.write(number, START_NS, [STORE.codec(name).encode(value)])
    writer.close()
    tables = Export(BagReader(path), topics=["/arm/*"], report=print).tables
    assert sorted(table.name for table in tables) == ["arm.x", "arm.x.2"]


def test_a_type_that_parquet_does_not_support_is_reported_and_leaves_no_file(tmp_path: Path) -> None:
    definition = f"E[] parts\n{'=' * 80}\nMSG: t/E\n"
    codec = Decoder().codec(Connection("/e", MessageType("t/M", "*", definition)))
    with pytest.raises(RecordingError, match=r"no child field.*; choose other fields, or the format CSV"):
        ParquetTable(tmp_path / "t.parquet", columns_of(codec))
    assert not (tmp_path / "t.parquet").exists()


def test_texts_of_boards_are_no_formulas_in_spreadsheets(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    texts = ("=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "fine", "'quoted", "")
    codec = STORE.codec("std_msgs/String")
    writer = BagWriter(path)
    number = writer.add_connection(Connection("/a", STORE.registry.message_type("std_msgs/String")))
    writer.write(number, START_NS, [codec.encode({"data": each}) for each in texts])
    writer.close()
    shown = [row["data"] for row in _csv(path, "/a")]
    assert shown == ["'=1+1", "'+1", "'-1", "'@SUM(A1)", "'\t=1", "fine", "'quoted", ""]


def test_pictures_with_the_same_time_are_all_kept(tmp_path: Path) -> None:
    codec = STORE.codec(PICTURE_TYPE)
    folder = PictureTable(tmp_path / "pictures")
    for data in (b"1", b"2", b"3"):
        folder.add(START_NS, codec.decode(codec.encode({"format": "jpeg", "data": data})))
    folder.add(START_NS + 1_000_000, codec.decode(codec.encode({"format": "png", "data": b"4"})))
    assert sorted(each.read_bytes() for each in (tmp_path / "pictures").iterdir()) == [b"1", b"2", b"3", b"4"]

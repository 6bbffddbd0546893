"""One bag with a topic of every type that both ROS 1 and ROS 2 have, converted to ROS 2 recordings and
back.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from property.test_cdr_against_rosbags import ROSBAGS, STORE, TYPES
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.writer import BagWriter
from rostether.recording.files import Form, open_recording
from rostether.recording.recorded import Connection
from rostether.recording.reindexing import copy
from rostether.serde.cdr.conversion_tree import DUMMY_NAME
from unit.recording.bags import START_NS
from unit.serde.random_messages import RandomMessages

pytestmark = pytest.mark.slow

rosbag2: Any = pytest.importorskip("rosbags.rosbag2")
TYPESYS: Any = pytest.importorskip("rosbags.typesys")


def _write_bag(path: Path) -> dict[str, bytes]:
    writer, random = BagWriter(path), RandomMessages(3)
    written = {}
    for number, name in enumerate(TYPES):
        topic = f"/{name.replace('/', '_')}"
        connection = Connection(topic, STORE.registry.message_type(name), "/node")
        written[topic] = STORE.codec(name).encode(random.message(STORE.codec(name)))
        writer.write(writer.add_connection(connection), START_NS + number, [written[topic]])
    writer.close()
    return written


def _convert(
    source: Path, target: Path, form: Form, *, is_native: bool = False, storage: str = "mcap"
) -> None:
    reader = open_recording(source, is_native=is_native)
    assert copy(reader, target, form=form, storage=storage) == len(TYPES)
    assert not reader.unreadable
    reader.close()


def test_every_type_is_unchanged_after_conversion_through_both_storages(tmp_path: Path) -> None:
    written = _write_bag(tmp_path / "a.bag")
    _convert(tmp_path / "a.bag", tmp_path / "mcap", Form.ROS2)
    _convert(tmp_path / "mcap", tmp_path / "sqlite", Form.ROS2, is_native=True, storage="sqlite3")
    for folder in ("mcap", "sqlite"):
        with rosbag2.Reader(tmp_path / folder) as reader:
            found = {each.topic: (each.msgtype, bytes(data)) for each, _, data in reader.messages()}
            for connection in reader.connections:
                name = connection.msgtype
                # rosidl treats `char` in a .msg as uint8, and so does rostether.
                assert connection.digest == ROSBAGS.hash_rihs01(name) or name == "std_msgs/msg/Char"
                # The file has the complete definition: rosbags needs nothing else to read the type.
                parsed = TYPESYS.get_types_from_msg(connection.msgdef.data, name)[name][1]
                expected = ROSBAGS.fielddefs[name][1]
                assert parsed == [each for each in expected if each[0] != DUMMY_NAME]
        assert found.keys() == written.keys()
        for topic, (name, cdr) in found.items():
            assert cdr == bytes(ROSBAGS.ros1_to_cdr(written[topic], name))
    _convert(tmp_path / "sqlite", tmp_path / "b.bag", Form.ROS1)
    back = list(BagReader(tmp_path / "b.bag").messages())
    for each in back:
        assert each.connection.type == STORE.registry.message_type(each.connection.type.name)
        name = each.connection.type.name.replace("/", "/msg/")
        # The `seq` of a header is lost.
        cdr = bytes(ROSBAGS.ros1_to_cdr(each.payload, name))
        assert cdr == bytes(ROSBAGS.ros1_to_cdr(written[each.connection.topic], name))
    assert [each.time_ns - START_NS for each in back] == list(range(len(TYPES)))

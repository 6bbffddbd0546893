"""The handwritten serialization of rosgraph_msgs/Log is correct."""

from __future__ import annotations

from rostether.graph.log_message import LOG_TYPE, MAX_LOG_TEXT_BYTES, encode_log
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore


def test_the_codec_reads_it() -> None:
    payload = encode_log(
        sequence=2**32 + 7,
        stamp=Time(12, 34),
        level=Level.WARN,
        node_name="/board",
        text="too hot: 90 °C",
        topics=["/a", "/b"],
    )
    log = TypeStore(Registry()).codec("rosgraph_msgs/Log").decode(payload)
    assert (log.header.seq, log.header.stamp) == (7, Time(12, 34))
    assert (log.level, log.name, log.msg) == (4, "/board", "too hot: 90 °C")
    assert log.topics == ["/a", "/b"]
    assert (log.file, log.function, log.line) == ("", "", 0)


def test_its_type_is_the_registrys() -> None:
    known = Registry().message_type("rosgraph_msgs/Log")
    assert (LOG_TYPE.name, LOG_TYPE.md5sum) == (known.name, known.md5sum)
    learned = Registry(bundled=False)
    learned.add_full_text(LOG_TYPE.name, LOG_TYPE.definition)
    assert learned.message_type(LOG_TYPE.name).md5sum == known.md5sum


def test_endless_texts_are_cut() -> None:
    payload = encode_log(
        sequence=1, stamp=Time(), level=Level.INFO, node_name="/n", text="x" * (2 * MAX_LOG_TEXT_BYTES)
    )
    assert payload.count(b"x") == MAX_LOG_TEXT_BYTES

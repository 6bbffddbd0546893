"""The values that rosbag's Python module returns: messages, and facts about a bag."""

from __future__ import annotations

from typing import Any, NamedTuple

from rostether.recording.message_rates import message_rates_hz
from rostether.recording.recorded import RecordingReader
from rostether.rospy.client.stamps import Time
from rostether.rostime import NS_PER_S


class Compression:
    """The compressions of chunks."""

    NONE = "none"
    BZ2 = "bz2"
    LZ4 = "lz4"


class BagMessage(NamedTuple):
    """One message of a bag, and the time of its arrival."""

    topic: str
    message: Any
    timestamp: Time


class BagMessageWithConnectionHeader(NamedTuple):
    """One message of a bag with the connection header of its publisher."""

    topic: str
    message: Any
    timestamp: Time
    connection_header: dict[str, bytes]


class TopicTuple(NamedTuple):
    """One topic; `frequency` in Hz is None for fewer than two messages."""

    msg_type: str
    message_count: int
    connections: int
    frequency: float | None


class TypesAndTopicsTuple(NamedTuple):
    """Md5sums by type, and topics by name."""

    msg_types: dict[str, str]
    topics: dict[str, TopicTuple]


class CompressionTuple(NamedTuple):
    """The most frequent compression, and the bytes of all chunks before and after compression."""

    compression: str
    uncompressed: int
    compressed: int


def types_and_topics(reader: RecordingReader, names: frozenset[str] | None) -> TypesAndTopicsTuple:
    """Return a recording's types and topics; a frequency is the inverse of the median interval.

    Raises RecordingError.
    """
    counts = {each: n for each, n in reader.counts.items() if names is None or each.topic in names}
    types = {each.type.name: each.type.md5sum for each in counts}
    rates = message_rates_hz(reader, counts.__contains__)
    topics = {}
    for name in sorted({each.topic for each in counts}):
        own = [each for each in counts if each.topic == name]
        topics[name] = TopicTuple(
            own[0].type.name, sum(counts[each] for each in own), len(own), rates.get(name)
        )
    return TypesAndTopicsTuple(types, topics)


def compression_of(reader: RecordingReader) -> CompressionTuple:
    """Return how a recording's chunks are compressed."""
    shares = reader.compressions
    if not shares:
        return CompressionTuple("none", 0, 0)
    plain = sum(each.size_bytes for each in shares)
    return CompressionTuple(shares[0].name, plain, sum(each.compressed_bytes for each in shares))


def yaml_text(filename: str, reader: RecordingReader, key: str | None) -> str:
    """Return the output of `rosbag info -y`, or the value of one of its keys."""
    import yaml

    facts: dict[str, Any] = {"path": filename, "version": 2.0}
    if (span := reader.span_ns) is not None:
        start_s, end_s = span[0] / NS_PER_S, span[1] / NS_PER_S
        facts |= {"duration": end_s - start_s, "start": start_s, "end": end_s}
    found = types_and_topics(reader, None)
    facts |= {
        "size": reader.size_bytes,
        "messages": sum(reader.counts.values()),
        "indexed": not reader.damage,
        "compression": compression_of(reader).compression,
        "types": [{"type": name, "md5": md5sum} for name, md5sum in sorted(found.msg_types.items())],
        "topics": [
            {"topic": name, "type": topic.msg_type, "messages": topic.message_count}
            | ({"connections": topic.connections} if topic.connections > 1 else {})
            | ({"frequency": topic.frequency} if topic.frequency is not None else {})
            for name, topic in found.topics.items()
        ],
    }
    value = facts if key is None else facts[key]
    return yaml.safe_dump(value, sort_keys=False) if isinstance(value, dict | list) else str(value)

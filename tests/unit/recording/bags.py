"""Connections and bags that several tests use."""

from __future__ import annotations

from pathlib import Path

from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.recording.bag.writer import BagWriter
from rostether.recording.recorded import Connection, RecordingWriter
from rostether.rostime import NS_PER_S

STRING = Registry().message_type("std_msgs/String")
IMU = Registry().message_type("sensor_msgs/Imu")
START_NS = 1_700_000_000_123_456_789


def connection(
    topic: str = "/chatter", message_type: MessageType = STRING, caller: str = "/talker"
) -> Connection:
    return Connection(topic, message_type, caller)


def text(value: str) -> bytes:
    data = value.encode()
    return len(data).to_bytes(4, "little") + data


def write_reset(writer: RecordingWriter) -> None:
    """Write 30 messages, one a second from 1000 s on, and 20 more from 1 s on, as after a reset."""
    number = writer.add_connection(connection())
    for second in (*range(1000, 1030), *range(1, 21)):
        writer.write(number, second * NS_PER_S, [text(str(second))])
    writer.close()


def write_bag(
    path: Path, count: int = 30, *, compression: str = "none", chunk_bytes: int = 300, closes: bool = True
) -> list[tuple[str, int, bytes]]:
    """Write messages of two topics in small chunks; return (topic, time, payload) in their order."""
    writer = BagWriter(path, compression=compression, chunk_bytes=chunk_bytes)
    numbers = [writer.add_connection(connection(topic)) for topic in ("/a", "/b")]
    written = []
    for index in range(count):
        time_ns = START_NS + index * 10_000_000
        payload = text(f"message {index}")
        writer.write(numbers[index % 2], time_ns, [payload])
        written.append(("/ab"[0] + "ab"[index % 2], time_ns, payload))
    if closes:
        writer.close()
    else:
        writer.flush()
    return written

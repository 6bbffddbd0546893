from __future__ import annotations

import struct

import pytest

from rostether.bridge.outbound.stamps import Stamps, has_header, stamp_offset
from rostether.rosserial.clock_estimate import ClockEstimate
from rostether.rostime import Time
from unit.bridge.nodes import STORE, topic_info


@pytest.mark.parametrize(
    ("type_name", "offset"),
    [
        ("sensor_msgs/Range", 4),
        ("tf/tfMessage", 8),
        ("std_msgs/Header", None),
        ("std_msgs/String", None),
        ("std_msgs/Empty", None),
        ("sensor_msgs/PointCloud", 4),
        ("std_msgs/Float32MultiArray", None),
    ],
)
def test_where_the_stamp_is(type_name: str, offset: int | None) -> None:
    assert stamp_offset(STORE.registry, type_name) == offset


def test_the_offset_is_that_of_the_codec() -> None:
    codec = STORE.codec("tf/tfMessage")
    stamp = Time(1_700_000_000, 5)
    payload = codec.encode({"transforms": [{"header": {"seq": 7, "stamp": stamp}}]})
    assert struct.unpack_from("<II", payload, 8) == (1_700_000_000, 5)


def test_a_flood_is_sampled_fifty_times_a_second() -> None:
    taken: list[int] = []

    class Spy(ClockEstimate):
        def stamped(self, stamp_ns: int, host_ns: int, now_s: float) -> None:
            taken.append(stamp_ns)

    stamps = Stamps(Spy(), lambda: Time(1_700_000_000, 0))
    stamps.announced(topic_info("range", "sensor_msgs/Range", topic_id=125), STORE.registry)
    assert stamps.offsets == {125: 4}
    payload = struct.pack("<III", 0, 1_700_000_000, 5)
    for number in range(1000):
        stamps.track(125, [b"", payload], number / 1000)
    assert 45 <= len(taken) <= 51
    assert taken[0] == 1_700_000_000 * 10**9 + 5
    stamps.track(125, [b"short"], 100.0)


def test_types_without_a_stamp_cost_nothing() -> None:
    stamps = Stamps(ClockEstimate(), lambda: Time(1, 0))
    stamps.announced(topic_info(), STORE.registry)
    assert stamps.offsets == {}


@pytest.mark.parametrize(
    ("type_name", "expected"),
    [
        ("sensor_msgs/Imu", True),
        ("std_msgs/Header", False),
        ("std_msgs/String", False),
        ("std_msgs/Empty", False),
        ("tf/tfMessage", False),
    ],
)
def test_ros_clients_count_messages_with_a_header(type_name: str, expected: bool) -> None:
    assert has_header(STORE.registry, type_name) is expected


def test_an_id_that_gets_a_topic_without_stamps() -> None:
    stamps = Stamps(ClockEstimate(), Time)
    stamps.announced(topic_info("range", "sensor_msgs/Range", topic_id=125), STORE.registry)
    assert stamps.offsets == {125: 4}
    stamps.announced(topic_info("chatter", topic_id=125), STORE.registry)
    assert stamps.offsets == {}

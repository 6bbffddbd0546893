"""rosbags decodes encoded messages to the same values, for every bundled type that it also has."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from effort import effort
from property.message_strategies import messages
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

rosbags_typesys = pytest.importorskip("rosbags.typesys")

STORE = TypeStore(Registry())
ROSBAGS: Any = rosbags_typesys.get_typestore(rosbags_typesys.Stores.ROS1_NOETIC)
TYPES = [name for name in STORE.registry.messages() if name.replace("/", "/msg/") in ROSBAGS.types]


def test_most_types_are_compared() -> None:
    assert len(TYPES) > 120


@pytest.mark.parametrize("name", TYPES)
@settings(
    max_examples=effort(2, 4),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(data=st.data())
def test_rosbags_writes_back_the_same_bytes(name: str, data: st.DataObject) -> None:
    codec = STORE.codec(name)
    payload = codec.encode(data.draw(messages(codec, texts=st.text(max_size=8))))
    rosbags_name = name.replace("/", "/msg/")
    decoded = ROSBAGS.deserialize_ros1(payload, rosbags_name)
    assert bytes(ROSBAGS.serialize_ros1(decoded, rosbags_name)) == payload

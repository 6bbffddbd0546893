"""Messages as JSON."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from rostether.msgdef.registry import Registry
from rostether.rostime import Duration, Time
from rostether.serde.plain_form import base64_text, plain_value, to_plain
from rostether.serde.store import TypeStore
from rostether.serde.yaml_form import parse_values
from unit.serde.random_messages import RandomMessages

STORE = TypeStore(Registry())


def test_fields_keep_their_order() -> None:
    header = STORE.codec("std_msgs/Header").message_class(seq=1, stamp=Time(2, 3), frame_id="map")
    assert json.dumps(to_plain(header)) == '{"seq": 1, "stamp": {"secs": 2, "nsecs": 3}, "frame_id": "map"}'


@pytest.mark.parametrize(
    ("value", "plain"),
    [
        (b"\1\2", [1, 2]),
        (Duration(-1, 5), {"secs": -1, "nsecs": 5}),
        ([Time(1, 2)], [{"secs": 1, "nsecs": 2}]),
        (math.nan, "NaN"),
        (math.inf, "Infinity"),
        ([1.5, -math.inf], [1.5, "-Infinity"]),
        (True, True),
        ("é\udcff", "é\ufffd"),
        ([[1], ["a"]], [[1], ["a"]]),
    ],
)
def test_values(value: Any, plain: Any) -> None:
    assert plain_value(value) == plain


@pytest.mark.parametrize("name", STORE.registry.messages())
def test_json_can_be_published_again(name: str) -> None:
    codec = STORE.codec(name)
    message = RandomMessages(seed=5).message(codec)
    text = json.dumps(to_plain(message), allow_nan=False)
    assert parse_values(codec, text, now=Time) == message


def test_a_parameter_with_bytes() -> None:
    value = {"key": b"\0\1", "limits": [1.5, math.inf]}
    assert plain_value(value, base64_text) == {"key": "AAE=", "limits": [1.5, "Infinity"]}

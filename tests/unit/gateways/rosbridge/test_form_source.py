from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from effort import effort
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.values import JsonForm, write_json
from rostether.msgdef.registry import Registry
from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct

STORE = TypeStore(Registry())
FORMS = {style: JsonForm(style) for style in Style}

EVERYTHING = """\
bool flag
int8 small
uint64 large
float32 single
float64 double
string words
time at
duration span
uint8[] raw
uint8[3] fixed_raw
bool[] flags
int16[] numbers
float32[] singles
float64[2] pair
string[] texts
time[] times
test_msgs/Empty nothing
test_msgs/Pair from
test_msgs/Pair[] pairs
================================================================================
MSG: test_msgs/Empty
================================================================================
MSG: test_msgs/Pair
float64 x
int32 lambda
"""


def everything() -> Codec:
    registry = Registry(bundled=False)
    registry.add_full_text("test_msgs/Everything", EVERYTHING)
    return TypeStore(registry).codec("test_msgs/Everything")


def value(node: Node, draw: Callable[[st.SearchStrategy[Any]], Any]) -> Any:
    if isinstance(node, Struct):
        return {member.name: value(member.node, draw) for member in node.members}
    if isinstance(node, Array):
        size = node.length if node.length is not None else draw(st.integers(0, 3))
        if node.is_bytes:
            return draw(st.binary(min_size=size, max_size=size))
        return [value(node.element, draw) for _ in range(size)]
    if isinstance(node, Stamp):
        return (
            Time(*draw(st.tuples(*[st.integers(0, 2**32 - 1)] * 2)))
            if node.name == "time"
            else (Duration(*draw(st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 2))))
        )
    if isinstance(node, Number):
        if node.code == "?":
            return draw(st.booleans())
        if node.code in "fd":
            return draw(st.floats(width=32 if node.code == "f" else 64))
        bits = 8 * node.fixed_size_bytes
        low = -(2 ** (bits - 1)) if node.code.islower() else 0
        return draw(st.integers(low, low + 2**bits - 1))
    return draw(st.text(max_size=5))


CODEC = everything()


@settings(max_examples=effort(60, 200), deadline=None)
@given(st.data(), st.sampled_from(Style))
def test_the_fast_path_equals_the_slow_path(data: st.DataObject, style: Style) -> None:
    payload = CODEC.encode(value(CODEC.tree, data.draw))
    form = FORMS[style]
    assert form.text(CODEC, payload) == write_json(form.to_json(CODEC, payload))


@pytest.mark.parametrize("style", Style)
def test_every_type_we_bring_can_be_written(style: Style) -> None:
    form = JsonForm(style)
    for name in STORE.registry.messages():
        codec = STORE.codec(name)
        payload = codec.encode({})
        assert form.text(codec, payload) == write_json(form.to_json(codec, payload)), name


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 1.7e308])
def test_what_adds_up_to_no_number_goes_the_slow_way(number: float) -> None:
    codec = STORE.codec("geometry_msgs/Vector3")
    payload = codec.encode({"x": number, "y": number})
    shown = number if math.isfinite(number) else "null"
    assert FORMS[Style.ROS1].text(codec, payload) == f'{{"x":{shown},"y":{shown},"z":0.0}}'


def test_large_types_have_functions_below() -> None:
    registry = Registry(bundled=False)
    fields = "".join(f"test_msgs/Many part_{number}\n" for number in range(10))
    many = "".join(f"float64 x_{number}\n" for number in range(100))
    registry.add_full_text("test_msgs/All", f"{fields}{'=' * 80}\nMSG: test_msgs/Many\n{many}")
    codec = TypeStore(registry).codec("test_msgs/All")
    payload = codec.encode({})
    form = JsonForm()
    assert form.text(codec, payload) == write_json(form.to_json(codec, payload))

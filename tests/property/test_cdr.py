"""Conversion has the same result as a slow, simple CDR writer, for any values of any definitions."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from effort import effort
from property.message_strategies import messages
from rostether.errors import SerializationError
from rostether.serde.cdr.converter import CdrConverter
from unit.serde.cdr.pairs import Pairs
from unit.serde.cdr.reference import CdrWriter

SETTINGS = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
NAMES = ["L0", "L1", "L2"]
SCALARS = {
    **{name: name for name in ("bool", "byte", "char", "string", "float32", "float64")},
    **{f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    "time": "builtin_interfaces/Time",
    "duration": "builtin_interfaces/Duration",
    "std_msgs/Header": "std_msgs/Header",
}


@st.composite
def definitions(draw: st.DrawFn) -> Pairs:
    """Return three nested messages as both sides define them; the order of the fields may differ."""
    ros1: dict[str, str] = {}
    ros2: dict[str, str] = {}
    for level, name in enumerate(NAMES):
        types = SCALARS | {below: below for below in NAMES[:level]}
        lines = []
        for index in range(draw(st.integers(0, 5))):
            type_ = draw(st.sampled_from(sorted(types)))
            array = draw(st.sampled_from(["", "", "[]", "[2]"]))
            lines.append((f"{type_}{array} f{index}", f"{types[type_]}{array} f{index}"))
        ros1[name] = "\n".join(line for line, _ in lines)
        if draw(st.booleans()) and draw(st.booleans()):
            lines = draw(st.permutations(lines))
        ros2[name] = "\n".join(line for _, line in lines)
    return Pairs(ros1, ros2)


@settings(SETTINGS, max_examples=effort(50, 150))
@given(data=st.data(), pairs=definitions())
def test_any_values_of_any_definitions(data: st.DataObject, pairs: Pairs) -> None:
    codec, ros2 = pairs.store.codec("test/L2"), pairs.ros2("test/msg/L2")
    converter = pairs.converter("L2", "L2")
    for _ in range(3):
        value = data.draw(messages(codec))
        payload = codec.encode(value)
        cdr = CdrWriter(pairs.ros2).encoded(ros2, value)
        assert converter.to_cdr(payload) == cdr
        back = converter.from_cdr(cdr)
        assert converter.to_cdr(back) == cdr
        assert len(back) == len(payload)
        assert converter.from_cdr(CdrWriter(pairs.ros2, ">").encoded(ros2, value)) == back


@settings(SETTINGS, max_examples=effort(30, 100))
@given(data=st.data(), pairs=definitions())
def test_any_bytes_are_converted_or_refused(data: st.DataObject, pairs: Pairs) -> None:
    codec, converter = pairs.store.codec("test/L2"), pairs.converter("L2", "L2")
    value = data.draw(messages(codec))
    payload = codec.encode(value)
    for raw in (data.draw(st.binary(max_size=80)), _damage(data, payload)):
        if codec.layout.accepts(raw):
            converter.to_cdr(raw)
        else:
            _require_refusal_in_one_line(converter, raw)
    for cdr in (data.draw(st.binary(max_size=80)), _damage(data, converter.to_cdr(payload))):
        for head in (b"\0\1\0\0", b"\0\0\0\0"):
            try:
                back = converter.from_cdr(head + cdr[4:])
            except SerializationError as error:
                assert "\n" not in str(error)
            else:
                assert codec.layout.accepts(back)


def _damage(data: st.DataObject, payload: bytes) -> bytes:
    damaged = bytearray(payload)
    for _ in range(data.draw(st.integers(0, 3)) if damaged else 0):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    return bytes(damaged[: data.draw(st.integers(0, len(damaged)))])


def _require_refusal_in_one_line(converter: CdrConverter, payload: bytes) -> None:
    with pytest.raises(SerializationError) as caught:
        converter.to_cdr(payload)
    assert "\n" not in str(caught.value)

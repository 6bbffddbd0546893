from __future__ import annotations

import contextlib
import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rostether.errors import RemoteProtocolError
from rostether.gateways.foxglove.client_messages import (
    Advertise,
    ClientChannel,
    FetchAsset,
    GetParameters,
    GivenParameter,
    GivenSubscription,
    MessageData,
    ServiceRequest,
    SetParameters,
    Subscribe,
    parse_binary,
    parse_text,
)


def test_messages_are_read() -> None:
    for text, wanted in (
        (
            '{"op":"subscribe","subscriptions":[{"id":0,"channelId":4294967295}]}',
            Subscribe((GivenSubscription(0, 4294967295),)),
        ),
        ('{"op":"getParameters","parameterNames":["a"],"id":"x"}', GetParameters(("a",), "x")),
        ('{"op":"getParameters","parameterNames":[]}', GetParameters((), None)),
        (
            '{"op":"setParameters","parameters":[{"name":"a","value":"AP8=","type":"byte_array"}]}',
            SetParameters((GivenParameter("a", "AP8=", "byte_array"),), None),
        ),
        ('{"op":"fetchAsset","uri":"package://a","requestId":3}', FetchAsset("package://a", 3)),
        (
            '{"op":"advertise","channels":[{"id":1,"topic":"/a","encoding":"ros1",'
            '"schemaName":"a/B","schema":"int8 x"}]}',
            Advertise((ClientChannel(1, "/a", "ros1", "a/B", "int8 x"),)),
        ),
    ):
        assert parse_text(text) == wanted
    assert parse_binary(b"\1\2\0\0\0abc") == MessageData(2, b"abc")
    assert parse_binary(b"\2" + b"\1\0\0\0\2\0\0\0\4\0\0\0ros1x") == ServiceRequest(1, 2, "ros1", b"x")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "{}",
        '{"op":[]}',
        '{"op":"nothing"}',
        '{"op":"subscribe","subscriptions":{}}',
        '{"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]}',
        '{"op":"subscribe","subscriptions":[{"id":true,"channelId":1}]}',
        '{"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]}',
        '{"op":"unsubscribe","subscriptionIds":["1"]}',
        '{"op":"getParameters","parameterNames":[1]}',
        '{"op":"fetchAsset","uri":1,"requestId":1}',
        json.dumps({"op": "getParameters", "parameterNames": [""] * 10_001}),
        json.dumps({"op": "fetchAsset", "uri": "x" * 5000, "requestId": 1}),
        "[" * 100_000,
    ],
)
def test_what_is_wrong_is_reported_in_one_short_line(text: str) -> None:
    with pytest.raises(RemoteProtocolError) as caught:
        parse_text(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


def test_a_wrong_field_is_named() -> None:
    with pytest.raises(RemoteProtocolError) as caught:
        parse_text('{"op":"subscribe","subscriptions":[{"id":1,"channelId":"1"}]}')
    assert str(caught.value) == "subscribe: subscriptions[0].channelId: expected integer, got string"


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", r"must begin with 1 \(message data\) or 2 \(service request\); it is empty"),
        (b"\x09a", r"must begin with 1 \(message data\) or 2 \(service request\), not 9"),
        (b"\1", "with opcode 1 ends early: it has 1 byte$"),
        (b"\2" + bytes(11), "with opcode 2 ends early: it has 12 bytes"),
    ],
)
def test_a_damaged_binary_message_is_explained(data: bytes, reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=reason):
        parse_binary(data)


@given(st.binary(max_size=40))
def test_any_bytes_are_a_message_or_an_error(data: bytes) -> None:
    with contextlib.suppress(RemoteProtocolError):
        parse_binary(data)


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)
_OPS = [
    "subscribe",
    "unsubscribe",
    "advertise",
    "unadvertise",
    "getParameters",
    "setParameters",
    "fetchAsset",
]
_FIELDS = [
    "subscriptions",
    "subscriptionIds",
    "channels",
    "channelIds",
    "parameterNames",
    "parameters",
    "uri",
    "id",
]


# On a machine under load, making examples takes long.
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(_OPS), st.dictionaries(st.sampled_from(_FIELDS), _JSON, max_size=3))
def test_any_json_is_a_message_or_an_error(op: str, fields: dict[str, object]) -> None:
    with contextlib.suppress(RemoteProtocolError):
        parse_text(json.dumps({**fields, "op": op}))


def test_texts_that_take_long_to_parse_are_refused() -> None:
    for part in ("1,", "[],", "{},"):
        with pytest.raises(RemoteProtocolError, match="at most"):
            parse_text('{"op": "getParameters", "parameterNames": [' + part * 300_000 + "1]}")

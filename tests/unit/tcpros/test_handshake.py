"""Handshake rules: the purpose of a connection by its first header, and which types agree."""

from __future__ import annotations

import pytest

from rostether.errors import GraphError, RemoteProtocolError, TypeMismatchError
from rostether.msgdef.interface import ANY_MESSAGE, MessageType, ServiceType
from rostether.tcpros import handshake
from rostether.tcpros.handshake import Purpose, purpose_of

STRING = MessageType("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
BOOL = MessageType("std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a", "bool data\n")
EMPTY = MessageType("std_srvs/EmptyRequest", "d41d8cd98f00b204e9800998ecf8427e")
SERVICE = ServiceType("std_srvs/Empty", "d41d8cd98f00b204e9800998ecf8427e", EMPTY, EMPTY)


@pytest.mark.parametrize(
    ("fields", "purpose"),
    [
        ({"topic": "/a", "md5sum": "*"}, Purpose.SUBSCRIBE),
        ({"service": "/a", "md5sum": "*"}, Purpose.CALL_ONCE),
        ({"service": "/a", "md5sum": "*", "persistent": "0"}, Purpose.CALL_ONCE),
        ({"service": "/a", "md5sum": "*", "persistent": "1"}, Purpose.CALL_PERSISTENT),
        ({"service": "/a", "md5sum": "*", "persistent": "True"}, Purpose.CALL_PERSISTENT),
        ({"service": "/a", "md5sum": "*", "probe": "1", "persistent": "1"}, Purpose.PROBE),
    ],
)
def test_the_first_header_decides(fields: dict[str, str], purpose: Purpose) -> None:
    assert purpose_of(fields) is purpose


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"md5sum": "*"}, "no topic or service"),
        ({}, "no topic or service"),
        ({"topic": "/a"}, "Missing required 'md5sum'"),
        ({"service": "/a", "probe": "1"}, "Missing required 'md5sum'"),
    ],
)
def test_headers_with_missing_fields_are_refused(fields: dict[str, str], reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=reason):
        purpose_of(fields)


@pytest.mark.parametrize("wanted", [STRING, ANY_MESSAGE, MessageType("other/Name", STRING.md5sum)])
def test_both_ends_agree(wanted: MessageType) -> None:
    asked = handshake.subscriber_fields("/a", wanted, caller_id="/me", tcp_nodelay=True)
    handshake.check_subscriber(asked, "/a", STRING)
    answer = handshake.publisher_fields("/a", STRING, caller_id="/you", latch=False)
    handshake.check_publisher(answer, "/a", wanted)
    assert answer["type"] == STRING.name


def test_an_error_names_types_that_differ() -> None:
    asked = handshake.subscriber_fields("/a", BOOL, caller_id="/me", tcp_nodelay=False)
    with pytest.raises(TypeMismatchError, match=r"\[std_msgs/Bool\] vs. \[std_msgs/String\]"):
        handshake.check_subscriber(asked, "/a", STRING)
    with pytest.raises(TypeMismatchError, match=r"Client \[/me\] wants topic \[/a\].*String/123\]"):
        handshake.check_subscriber({"type": STRING.name, "md5sum": "123", "callerid": "/me"}, "/a", STRING)
    answer = handshake.publisher_fields("/a", STRING, caller_id="/you", latch=False)
    with pytest.raises(TypeMismatchError, match="published as std_msgs/String"):
        handshake.check_publisher(answer, "/a", BOOL)


def test_an_error_answer_keeps_its_words_and_its_kind() -> None:
    with pytest.raises(TypeMismatchError, match="topic types do not match"):
        handshake.check_publisher({"error": "topic types do not match: [a] vs. [b]"}, "/a", STRING)
    with pytest.raises(GraphError, match="is not a publisher") as caught:
        handshake.check_publisher({"error": "[/n] is not a publisher of [/a]"}, "/a", STRING)
    assert not isinstance(caught.value, TypeMismatchError)
    with pytest.raises(RemoteProtocolError, match="lacks the field md5sum"):
        handshake.check_server({}, "/s", SERVICE)


def test_texts_of_a_peer_fit_a_line_of_the_log() -> None:
    huge = "\x1b[31m" + "md5sum\n" * 5000
    for fields in ({"error": huge}, {"type": huge, "md5sum": huge, "callerid": huge}):
        with pytest.raises(TypeMismatchError) as caught:
            handshake.check_publisher(fields, "/a", STRING)
        assert len(str(caught.value)) < 3 * handshake.MAX_SHOWN_CHARS
        assert str(caught.value).isprintable()
    with pytest.raises(TypeMismatchError) as refused:
        handshake.check_subscriber({"type": huge, "md5sum": huge, "callerid": huge}, "/a", STRING)
    assert len(str(refused.value)) < 3 * handshake.MAX_SHOWN_CHARS


def test_service_headers() -> None:
    client = handshake.client_fields("/s", SERVICE, caller_id="/me", persistent=True)
    assert purpose_of(client) is Purpose.CALL_PERSISTENT
    handshake.check_client(client, SERVICE)
    handshake.check_client(handshake.probe_fields("/s", caller_id="/me"), SERVICE)
    with pytest.raises(TypeMismatchError, match=r"from \[/me\]: md5sums do not match: \[1\] vs."):
        handshake.check_client({"md5sum": "1", "callerid": "/me"}, SERVICE)
    server = handshake.server_fields("/s", SERVICE, caller_id="/you")
    assert server["request_type"] == "std_srvs/EmptyRequest"
    handshake.check_server(server, "/s", SERVICE)
    with pytest.raises(TypeMismatchError, match="service /s has type std_srvs/Empty"):
        handshake.check_server(server | {"md5sum": "1"}, "/s", SERVICE)


def test_the_type_of_a_publisher_without_a_type_is_any() -> None:
    assert handshake.type_of({}) == MessageType("*", "*", "")
    answer = handshake.publisher_fields("/a", STRING, caller_id="/you", latch=False)
    assert handshake.type_of(answer) == STRING


def test_flags_of_publishers_and_subscribers() -> None:
    latched = handshake.publisher_fields("/a", STRING, caller_id="/you", latch=True)
    assert handshake.is_true(latched, "latching")
    quick = handshake.subscriber_fields("/a", STRING, caller_id="/me", tcp_nodelay=True)
    assert handshake.is_true(quick, "tcp_nodelay")
    assert not handshake.is_true({}, "tcp_nodelay")

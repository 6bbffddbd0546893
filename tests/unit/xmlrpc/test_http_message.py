"""HTTP for XML-RPC: each exchange is replayed whole, byte by byte and with trailing data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.errors import LocalProtocolError, RemoteProtocolError
from rostether.xmlrpc.http_message import HttpClientSide, HttpServerSide

# Requests as the peers in the field write them, all with the body "<call/>".
REQUESTS = {
    "roscpp": b"POST / HTTP/1.1\r\nUser-Agent: XMLRPC++ 0.7\r\nHost: localhost:11311\r\n"
    b"Content-Type: text/xml\r\nContent-length: 7\r\n\r\n<call/>",
    "python": b"POST /RPC2 HTTP/1.1\r\nHost: localhost:11311\r\nAccept-Encoding: gzip\r\n"
    b"Content-Type: text/xml\r\nUser-Agent: Python-xmlrpc/3.11\r\nContent-Length: 7\r\n\r\n<call/>",
    "http 1.0": b"POST / HTTP/1.0\r\nContent-Length: 7\r\n\r\n<call/>",
    "chunked": b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
    b"3\r\n<ca\r\n4\r\nll/>\r\n0\r\n\r\n",
    "no body type": b"POST /any/path HTTP/1.1\r\nHost: x\r\nContent-Length: 7\r\n\r\n<call/>",
}
RESPONSES = {
    "roscpp": b"HTTP/1.1 200 OK\r\nServer: XMLRPC++ 0.7\r\n"
    b"Content-Type: text/xml\r\nContent-length: 6\r\n\r\n<ans/>",
    "python": b"HTTP/1.1 200 OK\r\nServer: BaseHTTP/0.6 Python/3.11.2\r\n"
    b"Date: Mon, 01 Jan 2024 00:00:00 GMT\r\n"
    b"Content-type: text/xml\r\nContent-length: 6\r\n\r\n<ans/>",
    "chunked": b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n6\r\n<ans/>\r\n0\r\n\r\n",
}


def in_pieces(data: bytes) -> Iterable[list[bytes]]:
    """Return ways to cut a stream that have revealed faults of readers."""
    yield [data]
    yield [data[index : index + 1] for index in range(len(data))]
    yield [data[: len(data) // 2], data[len(data) // 2 :]]


def refused(request: bytes, **limits: Any) -> tuple[bytes, HttpServerSide]:
    server = HttpServerSide(**limits)
    server.receive_data(request)
    assert server.next_request() is None
    return server.data_to_send(), server


@pytest.mark.parametrize("name", REQUESTS)
def test_a_request_is_read_however_it_is_cut(name: str) -> None:
    for pieces in in_pieces(REQUESTS[name]):
        server = HttpServerSide()
        found = []
        for piece in pieces:
            server.receive_data(piece)
            if (body := server.next_request()) is not None:
                found.append(body)
        assert found == [b"<call/>"]


@pytest.mark.parametrize("name", [name for name in REQUESTS if name != "http 1.0"])
def test_requests_follow_each_other_on_one_connection(name: str) -> None:
    server = HttpServerSide()
    server.receive_data(REQUESTS[name] * 3)
    for _ in range(3):
        assert server.next_request() == b"<call/>"
        assert server.next_request() is None, "the next one waits for the answer"
        assert not server.is_idle
        server.send_response(b"<answer/>")
        assert server.data_to_send().endswith(b"<answer/>")
    assert server.next_request() is None
    assert server.is_idle
    assert not server.has_ended


def test_a_response_is_one_that_roscpp_reads() -> None:
    server = HttpServerSide()
    server.receive_data(REQUESTS["roscpp"])
    server.next_request()
    server.send_response(b"<answer/>")
    head, _, body = server.data_to_send().partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 200 ")
    assert b"\r\nContent-Length: 9" in head
    assert b"chunked" not in head
    assert body == b"<answer/>"


@pytest.mark.parametrize("header", [b"Connection: close", b"connection: Close"])
def test_the_connection_closes_when_a_client_requests_it(header: bytes) -> None:
    server = HttpServerSide()
    server.receive_data(b"POST / HTTP/1.1\r\nHost: x\r\n" + header + b"\r\nContent-Length: 1\r\n\r\nx")
    server.next_request()
    server.send_response(b"y")
    assert server.has_ended


def test_http_1_0_ends_after_its_answer() -> None:
    server = HttpServerSide()
    server.receive_data(REQUESTS["http 1.0"])
    server.next_request()
    server.send_response(b"y")
    assert server.has_ended


def test_expect_continue_is_answered_before_the_body() -> None:
    server = HttpServerSide()
    server.receive_data(b"POST / HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 7\r\n\r\n")
    assert server.next_request() is None
    assert server.data_to_send().startswith(b"HTTP/1.1 100 ")
    server.receive_data(b"<call/>")
    assert server.next_request() == b"<call/>"


@pytest.mark.parametrize(
    ("request_bytes", "status"),
    [
        (b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"405"),
        (b"HEAD / HTTP/1.0\r\n\r\n", b"405 Method Not Allowed"),
        (b"POST / HTTP/1.1\r\nHost: x\r\nOrigin: http://evil.example\r\nContent-Length: 1\r\n\r\nx", b"403"),
        (b"POST / HTTP/1.1\r\nHost: x\r\nContent-Encoding: gzip\r\nContent-Length: 1\r\n\r\nx", b"400"),
        (b"POST / HTTP/1.1\r\nContent-Length: 1\r\n\r\nx", b"400"),
        (b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\nx", b"400"),
        (b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: gzip\r\n\r\nx", b"501"),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", b"400"),
        (b"nonsense\r\n\r\n", b"400"),
        (b"POST / HTTP/1.1\r\nHost: " + b"x" * 200_000, b"431 Request Header Fields Too Large"),
    ],
)
def test_what_is_not_ours_is_refused(request_bytes: bytes, status: bytes) -> None:
    answer, server = refused(request_bytes)
    assert answer.startswith(b"HTTP/1.1 " + status)
    assert server.has_ended
    server.receive_data(b"more")
    assert server.next_request() is None
    assert server.data_to_send() == b""


def test_a_browser_shows_the_reason() -> None:
    answer, _ = refused(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
    assert answer.endswith(b"this is an XML-RPC server of a ROS graph; send it a POST\n")


@pytest.mark.parametrize(
    "body",
    [
        b"Content-Length: 11\r\n\r\n",
        b"Transfer-Encoding: chunked\r\n\r\n5\r\naaaaa\r\n6\r\naaaaaa\r\n",
    ],
)
def test_a_body_above_the_limit_is_refused_before_it_ends(body: bytes) -> None:
    answer, server = refused(b"POST / HTTP/1.1\r\nHost: x\r\n" + body, max_body_bytes=10)
    assert answer.startswith(b"HTTP/1.1 413 ")
    assert b"larger than 10 bytes" in answer
    assert server.has_ended


def test_an_early_end_is_not_a_request() -> None:
    server = HttpServerSide()
    server.receive_data(REQUESTS["python"][:-3])
    server.receive_data(b"")
    assert server.next_request() is None
    assert server.has_ended


def test_no_response_without_a_request() -> None:
    server = HttpServerSide()
    server.receive_data(REQUESTS["python"])
    server.next_request()
    server.send_response(b"x")
    with pytest.raises(LocalProtocolError, match="no response can be sent now"):
        server.send_response(b"x")


@pytest.mark.parametrize("name", RESPONSES)
def test_a_response_is_read_however_it_is_cut(name: str) -> None:
    for pieces in in_pieces(RESPONSES[name]):
        client = HttpClientSide("localhost:11311")
        for _ in range(2):
            request = client.send_request(b"<call/>")
            assert request.startswith(b"POST / HTTP/1.1\r\nHost: localhost:11311\r\n")
            assert request.endswith(b"\r\n\r\n<call/>")
            assert not client.is_reusable
            assert not client.has_answer_begun
            answers = [client.receive_data(piece) for piece in pieces]
            assert answers[-1] == b"<ans/>"
            assert answers[:-1] == [None] * (len(pieces) - 1)
            assert client.has_answer_begun
            assert client.is_reusable


@pytest.mark.parametrize(
    "response",
    [
        b"HTTP/1.0 200 OK\r\nContent-Type: text/xml\r\n\r\n<ans/>",
        b"HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n<ans/>",
    ],
)
def test_an_answer_without_length_ends_with_the_connection(response: bytes) -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    assert client.receive_data(response) is None
    assert client.receive_data(b"") == b"<ans/>"
    assert not client.is_reusable


def test_an_informational_answer_is_skipped() -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    assert client.receive_data(b"HTTP/1.1 100 Continue\r\n\r\n" + RESPONSES["python"]) == b"<ans/>"


def test_bytes_beyond_the_answer_end_the_connection() -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    assert client.receive_data(RESPONSES["python"] * 2) == b"<ans/>"
    assert not client.is_reusable


def test_the_path_of_the_uri_is_requested() -> None:
    assert HttpClientSide("x", path="/RPC2").send_request(b"").startswith(b"POST /RPC2 HTTP/1.1\r\n")


@pytest.mark.parametrize(
    ("response", "reason"),
    [
        (b"HTTP/1.1 404 Not Found\r\nContent-Length: 12\r\n\r\nno such page", "status 404: no such page"),
        (b"HTTP/1.1 500 Oops\r\nContent-Length: 0\r\n\r\n", "status 500"),
        (b"SSH-2.0-OpenSSH_9.2\r\n\r\n", "not HTTP"),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 11\r\n\r\n12345678901", "larger than 10 bytes"),
    ],
)
def test_invalid_answers_are_reported(response: bytes, reason: str) -> None:
    client = HttpClientSide("x", max_body_bytes=10 if "larger" in reason else 1000)
    client.send_request(b"")
    with pytest.raises(RemoteProtocolError, match=reason):
        client.receive_data(response)


@pytest.mark.parametrize("begin", [b"", b"HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\nhalf"])
def test_an_end_before_the_answer_is_an_error(begin: bytes) -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    if begin:
        assert client.receive_data(begin) is None
    with pytest.raises(RemoteProtocolError):
        client.receive_data(b"")
    assert client.has_answer_begun is bool(begin)


def test_one_exchange_at_a_time() -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    with pytest.raises(LocalProtocolError, match="no request can be sent now"):
        client.send_request(b"")


@st.composite
def damaged(draw: st.DrawFn, messages: dict[str, bytes]) -> list[bytes]:
    """Draw messages with some bytes replaced, removed or added, cut into pieces."""
    stream = bytearray(b"".join(draw(st.lists(st.sampled_from(sorted(messages.values())), max_size=3))))
    for _ in range(draw(st.integers(0, 4))):
        place = draw(st.integers(0, len(stream)))
        stream[place : place + draw(st.integers(0, 3))] = draw(st.binary(max_size=3))
    size = draw(st.integers(1, 200))
    return [bytes(stream[start : start + size]) for start in range(0, len(stream), size)]


@given(damaged(REQUESTS))
def test_a_damaged_request_never_raises(pieces: list[bytes]) -> None:
    server = HttpServerSide()
    for piece in [*pieces, b""]:
        server.receive_data(piece)
        while not server.has_ended and server.next_request() is not None:
            server.send_response(b"x")
        server.data_to_send()
        if server.has_ended:
            break
    assert server.has_ended or pieces == []


@given(damaged(RESPONSES))
def test_a_damaged_response_raises_only_our_error(pieces: list[bytes]) -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    try:
        for piece in [*pieces, b""]:
            if client.receive_data(piece) is not None:
                break
    except RemoteProtocolError as error:
        assert "\n" not in str(error)


def test_chunks_may_be_small_but_not_tiny() -> None:
    head = b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
    server = HttpServerSide()
    server.receive_data(head + b"40\r\n" + b"x" * 64 + b"\r\n0\r\n\r\n")
    assert server.next_request() == b"x" * 64
    server = HttpServerSide()
    server.receive_data(head + b"1\r\nx\r\n" * 2000)
    while server.next_request() is None and server.is_behind:
        pass
    assert b"400 Bad Request" in server.data_to_send()


def test_an_answer_in_tiny_chunks_is_refused() -> None:
    client = HttpClientSide("x")
    client.send_request(b"")
    with pytest.raises(RemoteProtocolError, match="chunks of less than 64 bytes"):
        client.receive_data(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" + b"1\r\nx\r\n" * 2000)


def test_large_data_is_read_in_parts() -> None:
    server = HttpServerSide()
    server.receive_data(
        b"POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
        + b"1\r\nx\r\n" * 500
        + b"0\r\n\r\n"
    )
    assert server.next_request() is None
    assert server.is_behind
    for _ in range(20):
        body = server.next_request()
        if body is not None:
            break
    assert body == b"x" * 500


@pytest.mark.parametrize(
    "content_type",
    [
        b"text/plain; a=xml",
        b"application/x-www-form-urlencoded;xml",
        b"xml",
        b"text/xml2",
        b"text/plain\r\nContent-Type: text/xml",
    ],
)
def test_a_type_that_only_mentions_xml_is_refused(content_type: bytes) -> None:
    answer, _ = refused(b"POST / HTTP/1.1\r\nHost: x\r\nContent-Type: " + content_type + b"\r\n\r\n")
    assert answer.startswith(b"HTTP/1.1 415 ")


@pytest.mark.parametrize("content_type", [b"text/xml", b"Text/XML; charset=utf-8", b"application/xml"])
def test_types_of_xml_are_accepted(content_type: bytes) -> None:
    server = HttpServerSide()
    server.receive_data(
        b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\nContent-Type: " + content_type + b"\r\n\r\nx"
    )
    assert server.next_request() == b"x"


def test_a_request_to_another_machines_name_is_refused() -> None:
    request = b"POST / HTTP/1.1\r\nHost: rebound.example:11311\r\nContent-Length: 0\r\n\r\n"
    answer, _ = refused(request, is_own_host=lambda host: host == "robot:11311")
    assert answer.startswith(b"HTTP/1.1 403 ")
    assert b"'rebound.example:11311' is not a name of this machine" in answer
    server = HttpServerSide(is_own_host=lambda host: host == "robot:11311")
    server.receive_data(request.replace(b"rebound.example", b"robot"))
    assert server.next_request() == b""


def test_the_bytes_of_an_unfinished_body_are_counted() -> None:
    server = HttpServerSide()
    server.receive_data(REQUESTS["roscpp"][:-3])
    assert server.next_request() is None
    assert server.body_bytes == len("<call/>") - 3


def test_a_stream_that_ends_before_the_answer() -> None:
    client = HttpClientSide("localhost")
    client.send_request(b"<call/>")
    with pytest.raises(RemoteProtocolError, match="the answer is not HTTP"):
        client.receive_data(b"")

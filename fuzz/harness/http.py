"""HTTP of the XML-RPC servers and clients: an answer, an error of ours, or an ended connection."""

from __future__ import annotations

import contextlib

from rostether.errors import RemoteProtocolError
from rostether.xmlrpc.http_message import HttpClientSide, HttpServerSide

MAX_BODY_BYTES = 4096
MAX_REQUESTS = 1000


def seeds() -> list[bytes]:
    """Return requests and responses, good and odd."""
    post = b"POST /RPC2 HTTP/1.1\r\nHost: a\r\nContent-Type: text/xml\r\n"
    return [
        b"\x80" + post + b"Content-Length: 3\r\n\r\nabc" + post + b"Content-Length: 0\r\n\r\n",
        b"\x80" + post + b"Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\n\r\n",
        b"\x80" + post + b"Expect: 100-continue\r\nContent-Length: 9\r\n\r\nabc",
        b"\x80GET / HTTP/1.0\r\n\r\n",
        b"\x80HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabc",
        b"\x80HTTP/1.1 404 No\r\n\r\n<html>",
    ]


def run(data: bytes) -> None:
    """Serve the bytes, and take them for an answer."""
    middle = data[0] * (len(data) - 1) // 256 if data else 0
    parts = (data[1:][:middle], data[1:][middle:], b"")
    server = HttpServerSide(max_body_bytes=MAX_BODY_BYTES)
    for part in parts:
        if server.ended:
            break
        server.receive_data(part)
        for _ in range(MAX_REQUESTS):
            body = server.next_request()
            if body is None:
                break
            assert len(body) <= MAX_BODY_BYTES
            server.send_response(b"<x/>")
        server.data_to_send()
    client = HttpClientSide("host", max_body_bytes=MAX_BODY_BYTES)
    client.send_request(b"")
    with contextlib.suppress(RemoteProtocolError):
        for part in parts:
            if client.receive_data(part) is not None:
                break

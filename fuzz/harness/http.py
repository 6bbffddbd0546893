"""HTTP of the XML-RPC servers and clients: an answer, one of our errors, or an ended connection."""

from __future__ import annotations

import contextlib
import random
import re

from fuzz.grammar import near
from rostether.errors import RemoteProtocolError
from rostether.xmlrpc.http_message import HttpClientSide, HttpServerSide

MAX_BODY_BYTES = 200
MAX_REQUESTS = 1000


def seeds() -> list[bytes]:
    """Return requests and responses, valid and unusual."""
    post = b"POST /RPC2 HTTP/1.1\r\nHost: a\r\nContent-Type: text/xml\r\n"
    return [
        b"\x80" + post + b"Content-Length: 3\r\n\r\nabc" + post + b"Content-Length: 0\r\n\r\n",
        b"\x80" + post + b"Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\n\r\n",
        b"\x80" + post + b"Expect: 100-continue\r\nContent-Length: 9\r\n\r\nabc",
        b"\x80GET / HTTP/1.0\r\n\r\n",
        b"\x80HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabc",
        b"\x80HTTP/1.1 404 No\r\n\r\n<html>",
    ]


def generate(source: random.Random) -> bytes:
    """Return some requests, or a response, with bodies near the limit, with a length or in chunks."""
    if source.random() < 0.25:
        status = source.choice(("200 OK", "200 OK", "404 No", "100 Continue"))
        return source.randbytes(1) + f"HTTP/1.1 {status}\r\n".encode() + _body(source)
    messages = []
    for _ in range(source.randint(1, 4)):
        method = source.choice(("POST", "POST", "POST", "GET", "OPTIONS"))
        lines = [f"{method} / HTTP/1.{source.choice('110')}", "Host: a"]
        if source.random() < 0.2:
            lines.append(source.choice(("Origin: http://evil", "oRIGIN: null", "Content-Encoding: gzip")))
        if source.random() < 0.8:
            lines.append(
                f"Content-Type: {source.choice(('text/xml', 'text/xml', 'text/plain', 'image/png'))}"
            )
        messages.append("".join(f"{line}\r\n" for line in lines).encode() + _body(source))
    return source.randbytes(1) + b"".join(messages)


def _body(source: random.Random) -> bytes:
    """Return the header lines that describe a body, and the body."""
    body = b"x" * (near(source, MAX_BODY_BYTES) % 500 if source.random() < 0.6 else source.randint(0, 9))
    if source.random() < 0.5:
        reported = len(body) if source.random() < 0.9 else near(source, MAX_BODY_BYTES)
        return b"Content-Length: %d\r\n\r\n" % reported + body
    size = source.randint(1, 60)
    chunks = [body[start : start + size] for start in range(0, len(body), size)]
    coded = b"".join(b"%x\r\n%s\r\n" % (len(chunk), chunk) for chunk in chunks)
    return b"Transfer-Encoding: chunked\r\n\r\n" + coded + b"0\r\n\r\n"


def run(data: bytes) -> None:
    """Read the bytes as requests, and as a response."""
    middle = data[0] * (len(data) - 1) // 256 if data else 0
    parts = (data[1:][:middle], data[1:][middle:], b"")
    _serve(data[1:], parts)
    client = HttpClientSide("host", max_body_bytes=MAX_BODY_BYTES)
    client.send_request(b"")
    with contextlib.suppress(RemoteProtocolError):
        for part in parts:
            body = client.receive_data(part)
            if body is not None:
                assert len(body) <= MAX_BODY_BYTES, "a body larger than allowed"
                break


def _serve(stream: bytes, parts: tuple[bytes, ...]) -> None:
    server, served = HttpServerSide(max_body_bytes=MAX_BODY_BYTES), 0
    most_bytes = MAX_BODY_BYTES + max(map(len, parts))
    for part in parts:
        if server.has_ended:
            break
        server.receive_data(part)
        for _ in range(MAX_REQUESTS):
            body = server.next_request()
            if body is None:
                break
            served += 1
            assert len(body) <= MAX_BODY_BYTES, "a body larger than allowed"
            server.send_response(b"<x/>")
        assert server.body_bytes <= most_bytes, "more of a body is kept than allowed"
        server.data_to_send()
    head = re.split(rb"\r?\n\r?\n", stream, maxsplit=1)[0].lower()
    first = head.split(b" ", 1)[0]
    if b"\norigin:" in head or (head and first != b"post"):
        assert not served, "a request was served that must be refused"

"""HTTP for XML-RPC, sans I/O: POST bodies to a server, response bodies to a client.

h11 does the framing (Content-Length, chunked, HTTP/1.0 and 1.1, keep-alive); this adds what ROS peers need:
limits, one exchange at a time, and `Expect: 100-continue`. It also refuses browsers, because a web page can
make a browser POST to a loopback port. Only a browser sends an `Origin` header, so a request with one is
refused. A request whose `Host` is not a name of this machine is refused too: see `transports.own_names`.
"""

from __future__ import annotations

from collections.abc import Callable

import h11

from rostether.errors import LocalProtocolError, RemoteProtocolError

# The largest documents in practice are robot descriptions and whole parameter dumps, of a few MB.
MAX_BODY_BYTES = 16 * 1024 * 1024

# The minimum average size of chunks, because each costs a step. Senders fill chunks, but a few may be small.
MIN_CHUNK_BYTES = 64
SMALL_CHUNKS = 1024
# How many parts of a request are read in one step: a header, some chunks, an end. They take less than 1 ms.
EVENTS_AT_ONCE = 64

_XML_TYPES = (b"text/xml", b"application/xml")
_TYPE = b"content-type"
_TEXT_XML = (b"Content-Type", b"text/xml")
_REASONS = {
    400: b"Bad Request",
    403: b"Forbidden",
    405: b"Method Not Allowed",
    413: b"Content Too Large",
    415: b"Unsupported Media Type",
    431: b"Request Header Fields Too Large",
}


class HttpStatusError(RemoteProtocolError):
    """The HTTP status of the answer is not 200: the peer is an HTTP server, but not one for XML-RPC."""


class HttpServerSide:
    """The server side: `receive_data`, then alternately `next_request` and `send_response`."""

    def __init__(
        self, *, max_body_bytes: int = MAX_BODY_BYTES, is_own_host: Callable[[str], bool] = lambda _host: True
    ) -> None:
        self._connection = h11.Connection(h11.SERVER)
        self._is_own_host = is_own_host
        self._max_body_bytes = max_body_bytes
        self._body = bytearray()
        self._chunk_count = 0
        self._wants_body = True
        self._out = bytearray()

        # Whether `next_request` stopped before the end of its data: call it again soon.
        self.is_behind = False

    @property
    def has_ended(self) -> bool:
        """Whether the connection must be closed once `data_to_send` is written."""
        return self._connection.our_state in (h11.MUST_CLOSE, h11.CLOSED, h11.ERROR)

    @property
    def is_idle(self) -> bool:
        """Whether no request has begun."""
        return self._connection.their_state is h11.IDLE and not self._connection.trailing_data[0]

    @property
    def body_bytes(self) -> int:
        """How many bytes of the request's body have arrived."""
        return len(self._body)

    def data_to_send(self) -> bytes:
        """Return the bytes to write now."""
        data = bytes(self._out)
        self._out.clear()
        return data

    def receive_data(self, data: bytes) -> None:
        """Handle bytes from the peer, which may end anywhere; `b""` is the end of the stream."""
        self._connection.receive_data(data)

    def next_request(self) -> bytes | None:
        """Return the body of the next complete POST, None without one.

        Other requests are answered here, and the connection is closed: see `has_ended`.
        """
        try:
            return self._next_request()
        except h11.RemoteProtocolError as error:
            self._refuse(error.error_status_hint, str(error))
        return None

    def _next_request(self) -> bytes | None:
        self.is_behind = False
        for _ in range(EVENTS_AT_ONCE):
            if self.has_ended:
                return None
            if self._connection.our_state is h11.DONE and self._connection.their_state is h11.DONE:
                self._connection.start_next_cycle()
                self._body.clear()
                self._chunk_count = 0
            event = self._connection.next_event()
            if event is h11.NEED_DATA:
                if self._connection.they_are_waiting_for_100_continue:
                    self._send(h11.InformationalResponse(status_code=100, headers=[]))
                return None
            if event is h11.PAUSED or isinstance(event, h11.ConnectionClosed):
                return None
            if isinstance(event, h11.Request):
                self._check_request(event)
            elif isinstance(event, h11.Data):
                self._body += event.data
                self._chunk_count += event.chunk_start
                if len(self._body) > self._max_body_bytes:
                    self._refuse(413, f"the request is larger than {self._max_body_bytes} bytes")
                elif _has_tiny_chunks(self._chunk_count, len(self._body)):
                    self._refuse(
                        400, f"the request has chunks of less than {MIN_CHUNK_BYTES} bytes; send larger ones"
                    )
            else:  # h11.EndOfMessage
                return bytes(self._body)
        self.is_behind = True
        return None

    def _check_request(self, request: h11.Request) -> None:
        headers = dict(request.headers)
        self._wants_body = request.method != b"HEAD"
        if request.method != b"POST":
            self._refuse(405, "this is an XML-RPC server of a ROS graph; send it a POST")
        elif b"origin" in headers:
            self._refuse(403, "requests from web pages are refused")
        elif headers.get(b"content-encoding", b"identity") != b"identity":
            self._refuse(400, "compressed requests are not supported")
        elif not self._is_own_host(host := headers.get(b"host", b"localhost").decode("latin-1")):
            self._refuse(
                403,
                f"{host!r:.200} is not a name of this machine; use its address, or set ROS_HOSTNAME or "
                "--listen to this name",
            )
        elif any(_media_type(value) not in _XML_TYPES for name, value in request.headers if name == _TYPE):
            # A web page can send forms or plain text without permission. Some ROS clients send no type.
            self._refuse(415, "an XML-RPC request has the Content-Type text/xml")
        elif int(headers.get(b"content-length", b"0")) > self._max_body_bytes:
            self._refuse(413, f"the request is larger than {self._max_body_bytes} bytes")

    def send_response(self, body: bytes) -> None:
        """Answer the request with an XML-RPC document. Raises LocalProtocolError without a request."""
        self._respond(200, b"OK", body, [_TEXT_XML])

    def _refuse(self, status: int, text: str) -> None:
        if self._connection.our_state in (h11.IDLE, h11.SEND_RESPONSE):  # pragma: no branch - true so far
            headers = [(b"Content-Type", b"text/plain"), (b"Connection", b"close")]
            self._respond(status, _REASONS.get(status, b"Bad Request"), f"{text}\n".encode(), headers)
        if not self.has_ended:  # pragma: no cover - the answer above ends it
            self._connection.send_failed()

    def _respond(self, status: int, reason: bytes, body: bytes, headers: list[tuple[bytes, bytes]]) -> None:
        length = (b"Content-Length", b"%d" % len(body))
        try:
            self._send(h11.Response(status_code=status, reason=reason, headers=[*headers, length]))
            if self._wants_body:
                self._send(h11.Data(data=body))
            self._send(h11.EndOfMessage())
        except h11.LocalProtocolError as error:
            raise LocalProtocolError(f"no response can be sent now: {error}") from None

    def _send(self, event: h11.Event) -> None:
        self._out += self._connection.send(event) or b""


class HttpClientSide:
    """The client side of a connection: `send_request`, then `receive_data` until it returns the response."""

    def __init__(self, host: str, *, path: str = "/", max_body_bytes: int = MAX_BODY_BYTES) -> None:
        self._connection = h11.Connection(h11.CLIENT)
        self._target = path.encode("ascii", "replace")
        self._headers = [(b"Host", host.encode("ascii", "replace")), (b"User-Agent", b"rostether"), _TEXT_XML]
        self._max_body_bytes = max_body_bytes
        self._body = bytearray()
        self._chunk_count = 0
        self._status = 0
        self.has_answer_begun = False

    @property
    def is_reusable(self) -> bool:
        """Whether another request may be sent on this connection."""
        return self._connection.our_state is h11.IDLE

    def send_request(self, body: bytes) -> bytes:
        """Return the bytes of a POST. Raises LocalProtocolError while another exchange is in progress."""
        self._body.clear()
        self._chunk_count = 0
        self.has_answer_begun = False
        length = (b"Content-Length", b"%d" % len(body))
        request = h11.Request(method=b"POST", target=self._target, headers=[*self._headers, length])
        try:
            head = self._connection.send(request) or b""
            data = self._connection.send(h11.Data(data=body)) or b""
            return head + data + (self._connection.send(h11.EndOfMessage()) or b"")
        except h11.LocalProtocolError as error:
            raise LocalProtocolError(f"no request can be sent now: {error}") from None

    def receive_data(self, data: bytes) -> bytes | None:
        """Handle bytes, `b""` for the end of the stream; return the body once the response is complete.

        Raises HttpStatusError if the status is not 200, RemoteProtocolError if the data is not HTTP, is too
        long, or has tiny chunks.
        """
        try:
            self._connection.receive_data(data)
            self.has_answer_begun = self.has_answer_begun or bool(data)
            return self._read()
        except h11.RemoteProtocolError as error:
            raise RemoteProtocolError(f"the answer is not HTTP: {error}") from None

    def _read(self) -> bytes | None:
        while True:
            event = self._connection.next_event()
            if event is h11.NEED_DATA or event is h11.PAUSED:
                return None
            if isinstance(event, h11.Response):
                self._status = event.status_code
            elif isinstance(event, h11.Data):
                self._body += event.data
                if len(self._body) > self._max_body_bytes:
                    raise RemoteProtocolError(f"the answer is larger than {self._max_body_bytes} bytes")
                self._chunk_count += event.chunk_start
                if _has_tiny_chunks(self._chunk_count, len(self._body)):
                    raise RemoteProtocolError(f"the answer has chunks of less than {MIN_CHUNK_BYTES} bytes")
            elif isinstance(event, h11.EndOfMessage):
                return self._finish()
            elif isinstance(event, h11.ConnectionClosed):  # pragma: no cover - h11 raises first
                raise RemoteProtocolError("the connection ended before the answer")

    def _finish(self) -> bytes:
        if self._status != 200:
            text = self._body[:200].decode("utf-8", "replace").strip().replace("\n", " ")
            # A web page does not fit on one line.
            reason = "" if not text or text.startswith("<") else f": {text}"
            raise HttpStatusError(f"HTTP status {self._status}{reason}")
        # Bytes after the answer were not requested, and would look like the next answer.
        is_done = self._connection.our_state is h11.DONE and self._connection.their_state is h11.DONE
        if is_done and not self._connection.trailing_data[0]:
            self._connection.start_next_cycle()
        return bytes(self._body)


def _media_type(value: bytes) -> bytes:
    return value.partition(b";")[0].strip().lower()


def _has_tiny_chunks(count: int, body_bytes: int) -> bool:
    return count > SMALL_CHUNKS + body_bytes // MIN_CHUNK_BYTES

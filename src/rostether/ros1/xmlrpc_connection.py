"""One client's connection to an XML-RPC server: requests are answered one after the other."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import cast

from rostether.xmlrpc.http_message import HttpServerSide

# Nearly all requests are smaller. Larger ones are counted together, so that many cannot fill the memory.
_LARGE_BODY_BYTES = 256 * 1024


class ServerConnection(asyncio.Protocol):
    """Reads requests, passes each body to `answer` and writes the result; `on_lost` is called at the end.

    A large body continues only while `has_room` returns true; a large answer calls `make_room`. `admit`
    closes connections that are not allowed. After one request, or a large part of one, other connections are
    served first: `schedule` calls `resume` soon.

    While an answer is computed, or the client does not read, at most one more chunk is read. This limits
    the memory for each client, and still detects that a client has disconnected.
    """

    def __init__(
        self,
        answer: Callable[[bytes], bytes | Awaitable[bytes]],
        on_lost: Callable[[ServerConnection], None],
        has_room: Callable[[], bool],
        make_room: Callable[[], None],
        schedule: Callable[[ServerConnection], None],
        admit: Callable[[ServerConnection, asyncio.Transport], bool],
        *,
        max_body_bytes: int,
        is_own_host: Callable[[str], bool],
    ) -> None:
        self._answer = answer
        self._has_room = has_room
        self._make_room = make_room
        self._schedule = schedule
        self._waits_for_turn = False
        self._admit = admit
        self._on_lost = on_lost
        self._http = HttpServerSide(max_body_bytes=max_body_bytes, is_own_host=is_own_host)
        self._transport: asyncio.Transport | None = None
        self._task: asyncio.Future[bytes] | None = None
        self._is_congested = False
        self._loop = asyncio.get_running_loop()
        self.last_active_s = self._loop.time()
        # When the current request began, or the wait for the next one.
        self.waiting_since_s = self.last_active_s
        self.has_spoken = False
        self.host = ""

    @property
    def is_idle(self) -> bool:
        """Whether no request is in progress."""
        return self._task is None and not self._is_congested and self._http.is_idle

    @property
    def is_receiving(self) -> bool:
        """Whether a request has begun and is not complete."""
        return self._task is None and not self._is_congested and not self._http.is_idle

    @property
    def body_bytes(self) -> int:
        """How many bytes of the request's body have arrived."""
        return self._http.body_bytes

    @property
    def unsent_bytes(self) -> int:
        """The size of the answers that the client has not read yet."""
        return self._transport.get_write_buffer_size() if self._transport is not None else 0

    @property
    def is_answering(self) -> bool:
        """Whether a method is running."""
        return self._task is not None

    def close(self) -> None:
        """Close the connection after the written data was sent; a running method is canceled."""
        if self._task is not None:
            self._task.cancel()
        if self._transport is not None:
            self._transport.close()

    def abort(self) -> None:
        """End the connection immediately."""
        if self._transport is not None:
            self._transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Wait for a request, if the connection is admitted."""
        # uvloop's transports are not subclasses of asyncio's.
        self._transport = cast(asyncio.Transport, transport)
        peer = transport.get_extra_info("peername")
        self.host = peer[0] if peer else ""
        if not self._admit(self, self._transport):
            self._transport = None

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the running method, because no client waits for its result."""
        if self._task is not None:
            self._task.cancel()
        self._transport = None
        self._on_lost(self)

    def data_received(self, data: bytes) -> None:
        """Handle the next bytes of a request."""
        self.last_active_s = self._loop.time()
        if self._transport is None:
            return
        if self._http.is_idle:
            self.waiting_since_s = self.last_active_s
        self._http.receive_data(data)
        if self._task is None and not self._is_congested and not self._waits_for_turn:
            self._serve()
        else:
            self._pause()
        if self._http.body_bytes > _LARGE_BODY_BYTES and not self._has_room():
            self.abort()

    def pause_writing(self) -> None:
        """Stop: the client does not read."""
        self._is_congested = True
        self._pause()

    def resume_writing(self) -> None:
        """Write the waiting answers."""
        self._is_congested = False
        self._serve()

    def _pause(self) -> None:
        if self._transport is not None and not self._transport.is_closing():
            self._transport.pause_reading()

    def resume(self) -> None:
        """Read the next request, or more of it."""
        self._waits_for_turn = False
        self._serve()

    def _serve(self) -> None:
        if self._transport is None or self._task is not None or self._is_congested or self._waits_for_turn:
            return
        body = self._http.next_request()
        if data := self._http.data_to_send():
            self._transport.write(data)
        if body is not None:
            self.has_spoken = True
            self.waiting_since_s = self._loop.time()
            answer = self._answer(body)
            if isinstance(answer, bytes):
                self._respond(answer)
            else:
                self._task = asyncio.ensure_future(answer)
                self._task.add_done_callback(self._answered)
                return
        if body is not None or self._http.is_behind:
            self._waits_for_turn = True
            self._schedule(self)
        elif self._http.has_ended:
            self._transport.close()
        elif not self._transport.is_closing() and not self._is_congested:
            self._transport.resume_reading()

    def _answered(self, task: asyncio.Future[bytes]) -> None:
        self._task = None
        self.last_active_s = self._loop.time()
        if task.cancelled() or self._transport is None:
            return
        self._respond(task.result())
        self._serve()

    def _respond(self, answer: bytes) -> None:
        assert self._transport is not None
        self._http.send_response(answer)
        self._transport.write(self._http.data_to_send())
        if len(answer) > _LARGE_BODY_BYTES:
            self._make_room()

"""One WebSocket connection of a client: handshake, messages in and out, pings, and its end.

The WebSocket protocol itself is that of the library websockets, without I/O. Only frames with messages of
topics are written past it (see `data_outlet.py`).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from http import HTTPStatus
from typing import Any, Protocol

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import Frame, Opcode
from websockets.http11 import Request, Response
from websockets.protocol import OPEN
from websockets.server import ServerProtocol
from websockets.typing import Subprotocol

from rostether.gateways.foxglove.admission import Admission
from rostether.gateways.foxglove.data_outlet import DataOutlet
from rostether.gateways.foxglove.limits import FoxgloveLimits
from rostether.gateways.foxglove.server_messages import SUBPROTOCOLS
from rostether.gateways.websocket.site import Reply, Site, refusal

HIGH_WATER_BYTES = 1 << 20
"""What stands in the process for a client before messages wait in queues where they can be dropped: 50 ms of
what a fast network takes."""

_CLOSE_S = 5.0  # for a client to answer that the connection ends; then it is cut

# A phone on a weak network reads the largest file of the page in this time.
_FILE_S = 30.0


class LineUser(Protocol):
    """Receives the events of one connection."""

    def opened(self) -> None:
        """The handshake is done."""

    def received(self, message: str | bytes) -> None:
        """A whole message came."""

    def dropped(self, count: int) -> None:
        """So many messages more were lost because the client reads slowly."""

    def closed(self) -> None:
        """The connection has ended; also after a handshake that failed."""


class Line(asyncio.Protocol):
    """One connection; `user` is set by whoever made it."""

    user: LineUser

    def __init__(
        self,
        admission: Admission,
        limits: FoxgloveLimits,
        tell_refused: Callable[[str], None],
        site: Site | None = None,
    ) -> None:
        self._admission = admission
        self._site = site
        self._limits = limits
        self._tell_refused = tell_refused
        self._websocket = ServerProtocol(
            subprotocols=[Subprotocol(each) for each in SUBPROTOCOLS],
            select_subprotocol=_choose_subprotocol,
            max_size=limits.message_bytes,
        )
        self._loop = asyncio.get_running_loop()
        self._transport: asyncio.Transport | None = None
        self._data = DataOutlet(limits.waiting_bytes, lambda count: self.user.dropped(count))
        self._has_room = asyncio.Event()
        self._has_room.set()
        self._large_turn = asyncio.Lock()
        self._large_bytes = 0
        self._parts: list[bytes] = []
        self._is_text = False
        self._timer: asyncio.TimerHandle | None = None
        self._is_ending = False
        self._is_answered = True
        self._unsent_at_ping = 0

    @property
    def is_open(self) -> bool:
        """Whether messages can be sent."""
        return self._data.is_open

    # asyncio's side

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Wait for the handshake."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        transport.set_write_buffer_limits(high=HIGH_WATER_BYTES)
        self._timer = self._loop.call_later(self._limits.handshake_s, self.abort)

    def data_received(self, data: bytes) -> None:
        """Take bytes."""
        self._websocket.receive_data(data)
        self._work()

    def eof_received(self) -> bool:
        """Take the end."""
        self._websocket.receive_eof()
        self._work()
        return False

    def connection_lost(self, _: Exception | None) -> None:
        """Tell the user."""
        self._data.end()
        if self._timer is not None:
            self._timer.cancel()
        self.user.closed()

    def pause_writing(self) -> None:
        """Let messages of topics wait."""
        self._data.pause()
        self._has_room.clear()

    def resume_writing(self) -> None:
        """Send what waited."""
        self._large_bytes = 0
        self._has_room.set()
        self._data.resume()

    # the user's side

    def pause_reading(self) -> None:
        """Read no more, so that the client waits."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.pause_reading()

    def resume_reading(self) -> None:
        """Read again."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.resume_reading()

    def send(self, message: str | bytes) -> None:
        """Send an answer or an announcement; who does not read them is given up."""
        if not self.is_open or self._transport is None:
            return
        # What was gathered is older.
        self._data.flush()
        try:
            if isinstance(message, str):
                self._websocket.send_text(message.encode("utf-8", "replace"))
            else:
                self._websocket.send_binary(message)
        except ConnectionClosed:
            return
        self._write_control()
        allowed = self._limits.control_bytes + HIGH_WATER_BYTES + self._large_bytes
        if self._transport.get_write_buffer_size() > allowed:
            self.abort()

    async def send_large(self, message: bytes) -> None:
        """Send an answer of any size, as soon as the client has read the one before."""
        async with self._large_turn:
            await self._has_room.wait()
            self._large_bytes = len(message)
            self.send(message)

    def send_data(self, subscription_id: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Send messages of a topic, or let them wait."""
        self._data.send(subscription_id, time_ns, payloads)

    def forget(self, subscription_id: int) -> None:
        """Drop what waits for a subscription that has ended."""
        self._data.forget(subscription_id)

    def close(self, code: int = 1001, reason: str = "") -> None:
        """Say good-bye, and hang up when the client has answered or does not."""
        if not self.is_open or self._transport is None:
            self.abort()
            return
        self._data.flush()
        self._data.end()
        self._websocket.send_close(code, reason)
        self._write_control()
        self._set_timer(_CLOSE_S, self.abort)

    def abort(self) -> None:
        """Hang up now."""
        self._data.end()
        if self._transport is not None:
            self._transport.abort()

    # within

    def _work(self) -> None:
        for event in self._websocket.events_received():
            if isinstance(event, Request):
                self._shake_hands(event)
            elif isinstance(event, Frame):
                self._take(event)
        self._write_control()
        if self._websocket.state is not OPEN:
            self._data.end()
        if self._websocket.close_expected() and self._transport is not None and not self._is_ending:
            self._is_ending = True
            # A client that fell out of step is told why (RFC 6455, 7.4); then it hangs up, or we do.
            self._set_timer(_CLOSE_S, self.abort)

    def _shake_hands(self, request: Request) -> None:
        if self._site is not None and not _asks_for_websocket(request):
            self._serve_file(request)
            return
        reason = self._admission.refusal(request.path, request.headers)
        response: Response
        if reason is not None:
            self._tell_refused(reason)
            response = self._websocket.reject(403, reason + "\n")
        else:
            response = self._websocket.accept(request)
        self._websocket.send_response(response)
        self._write_control()
        if response.status_code != 101 or self._transport is None:
            return
        self._data.open(self._transport)
        self._set_timer(self._limits.ping_period_s, self._ping)
        self.user.opened()

    def _serve_file(self, request: Request) -> None:
        assert self._site is not None
        # Before websockets 17 only GET comes here, and requests have no method.
        method = getattr(request, "method", "GET")
        if (reason := self._admission.page_refusal(request.headers)) is not None:
            self._tell_refused(reason)
            reply = refusal(HTTPStatus.FORBIDDEN, reason)
        else:
            reply = self._site.reply(method, request.path, request.headers)
        self._websocket.send_response(_response(reply))
        # Whatever the client sends from now on, it does not gain time.
        self._is_ending = True
        self._set_timer(_FILE_S, self.abort)

    def _take(self, frame: Frame) -> None:
        self._is_answered = True
        if frame.opcode in (Opcode.TEXT, Opcode.BINARY):
            self._parts = [bytes(frame.data)]
            self._is_text = frame.opcode is Opcode.TEXT
        elif frame.opcode is Opcode.CONT:
            self._parts.append(bytes(frame.data))
        else:
            return
        if not frame.fin or not self.is_open:
            return
        data = self._parts[0] if len(self._parts) == 1 else b"".join(self._parts)
        self._parts = []
        self.user.received(data.decode("utf-8", "replace") if self._is_text else data)

    def _write_control(self) -> None:
        if self._transport is None:
            return
        for data in self._websocket.data_to_send():
            if data:
                self._transport.write(data)
            elif self._transport.can_write_eof():
                self._transport.write_eof()
            else:
                # TLS cannot close one half; what was written is sent before.
                self._transport.close()

    def _ping(self) -> None:
        # Who still reads what was sent is there, however long an answer takes behind it.
        if not self._is_answered and not self._is_moving():
            self.abort()
            return
        self._is_answered = False
        if self.is_open:
            self._websocket.send_ping(b"")
            self._write_control()
            self._set_timer(self._limits.ping_period_s, self._ping)

    def _is_moving(self) -> bool:
        unsent = self._transport.get_write_buffer_size() if self._transport is not None else 0
        before, self._unsent_at_ping = self._unsent_at_ping, unsent
        return unsent != before

    def _set_timer(self, delay_s: float, act: Callable[[], Any]) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._loop.call_later(delay_s, act)


def _asks_for_websocket(request: Request) -> bool:
    return any("websocket" in value.lower() for value in request.headers.get_all("Upgrade"))


def _response(reply: Reply) -> Response:
    headers = Headers(reply.headers)
    if reply.status is not HTTPStatus.NOT_MODIFIED:
        headers["Content-Length"] = str(reply.length)
    headers["Connection"] = "close"
    return Response(reply.status.value, reply.status.phrase, headers, reply.body)


def _choose_subprotocol(_: ServerProtocol, offered: Sequence[Subprotocol]) -> Subprotocol | None:
    # A client that names none is one written by hand for this very protocol.
    return next((Subprotocol(each) for each in SUBPROTOCOLS if each in offered), None)

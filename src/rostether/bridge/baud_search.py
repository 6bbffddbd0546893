"""Finds the baud rate at which a board answers, or at which what comes can be read."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace

from rostether.bridge.findings.noise import KEPT_BYTES, is_text
from rostether.errors import TransportError
from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.host_link import HostLink
from rostether.transports.address import Address, SerialAddress
from rostether.transports.transport import Transport

USUAL_BAUDS = (57600, 115200, 9600, 250000, 500000, 1000000, 38400, 19200, 230400, 460800, 921600, 2000000)
"""In the order in which sketches have them: the library's default first, then what tutorials write."""

ATTEMPT_S = 1.2
"""Four topic requests; a sketch whose loop() takes half a second answers one of them."""

FIRST_ATTEMPT_S = 3.0
"""The first opening without touching DTR may still reset a board: its boot loader takes up to 2 s."""

MIN_TEXT_BYTES = 16
"""Garbage passes for this much text once in a million tries."""


@dataclass(frozen=True, slots=True)
class BaudFound:
    """At which rate a board answered, else at which rate text could be read, with that text."""

    frames_at: int | None = None
    text_at: int | None = None
    text: bytes = b""


async def find_baud(
    address: SerialAddress,
    open_transport: Callable[[Address], Awaitable[Transport]],
    *,
    bauds: Sequence[int] = USUAL_BAUDS,
    on_attempt: Callable[[int], object] = lambda _baud: None,
    attempt_s: float = ATTEMPT_S,
    first_attempt_s: float = FIRST_ATTEMPT_S,
) -> BaudFound:
    """Try the rates in turn, other than the address's own. Raises TransportError if the port has gone.

    A rate that the port does not support is passed over.
    """
    text_at, text = None, b""
    limit_s = first_attempt_s
    for baud in bauds:
        if baud == address.baud:
            continue
        on_attempt(baud)
        try:
            transport = await open_transport(replace(address, baud=baud, reset=False))
        except TransportError:
            raise
        except Exception:  # noqa: BLE001, S112 - a rate that this port cannot have, in whatever words
            continue
        listener = _Listener(transport)
        is_found = await listener.listen(limit_s)
        limit_s = attempt_s
        if is_found:
            return BaudFound(baud, None, b"")
        if text_at is None and len(listener.noise) >= MIN_TEXT_BYTES and is_text(bytes(listener.noise)):
            text_at, text = baud, bytes(listener.noise)
    return BaudFound(None, text_at, text)


class _Listener:
    """Asks one open port for its topics until a frame comes that only a board sends."""

    def __init__(self, transport: Transport) -> None:
        self.noise = bytearray()
        self._transport = transport
        self._link = HostLink()
        self._loop = asyncio.get_running_loop()
        self._found = asyncio.Event()

    async def listen(self, limit_s: float) -> bool:
        """Return whether a board answered in time, and close the port."""
        self._link.start(self._loop.time())
        self._transport.start(self)
        self._send()
        deadline_s = self._loop.time() + limit_s
        while not self._found.is_set() and (now_s := self._loop.time()) < deadline_s:
            due_s = min(deadline_s, self._link.get_timer() or deadline_s)
            try:
                async with asyncio.timeout(max(0.0, due_s - now_s)):
                    await self._found.wait()
            except TimeoutError:
                self._take(self._link.handle_timer(self._loop.time()))
                self._send()
        self._transport.close()
        await self._transport.wait_closed()
        return self._link.version is not None

    def data_received(self, data: bytes) -> None:
        """Take a chunk from the port."""
        self._take(self._link.receive_data(data, self._loop.time()))
        if self._link.version is not None:
            self._found.set()

    def connection_lost(self, error: TransportError | None) -> None:
        """Learn that the port has gone."""
        self._found.set()

    def pause_writing(self) -> None:
        """A topic request is a few bytes."""

    def resume_writing(self) -> None:
        """As above."""

    def _take(self, events: Sequence[object]) -> None:
        for event in events:
            if isinstance(event, FrameDiscarded):
                self.noise += event.data[: KEPT_BYTES - len(self.noise)]

    def _send(self) -> None:
        data = self._link.data_to_send()
        if data:
            self._transport.write(data)

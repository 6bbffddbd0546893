"""Searches a port for a board, rate by rate: drives `BaudProbe`, opening the port anew for each rate.

After the first opening DTR stays as it is, so that a board which resets with it does so at most once more.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace

from rostether.errors import ConfigError, TransportError, TransportOpenError
from rostether.rosserial.baud_probe import USUAL_BAUDS, BaudProbe, BoardFound, NoBoard
from rostether.transports.address import Address, SerialAddress
from rostether.transports.transport import Transport


async def find_baud(
    address: SerialAddress,
    open_transport: Callable[[Address], Awaitable[Transport]],
    *,
    bauds: Sequence[int] = USUAL_BAUDS,
    on_attempt: Callable[[int], object] = lambda _baud: None,
) -> BoardFound | NoBoard:
    """Try the rates other than the address's own. Raises TransportError if the port cannot be opened.

    `on_attempt` is told of each rate once. Rates that the port does not support are passed over.
    """
    loop = asyncio.get_running_loop()
    probe = BaudProbe([baud for baud in bauds if baud != address.baud])
    probe.start(loop.time())
    told: set[int] = set()
    while probe.result is None:
        baud = probe.baud
        if baud not in told:
            told.add(baud)
            on_attempt(baud)
        line = _Line(probe)
        try:
            transport = await open_transport(replace(address, baud=baud, reset=False))
        except ConfigError:
            await line.run_while(baud)
            continue
        line.attach(transport)
        try:
            await line.run_while(baud)
        finally:
            transport.close()
            await transport.wait_closed()
        if line.failure is not None:
            raise line.failure
    return probe.result


class _Line:
    """One opening of the port."""

    def __init__(self, probe: BaudProbe) -> None:
        self.failure: TransportError | None = None
        self._probe = probe
        self._transport: Transport | None = None
        self._loop = asyncio.get_running_loop()
        self._stirred = asyncio.Event()

    def attach(self, transport: Transport) -> None:
        """Use the port."""
        self._transport = transport
        transport.start(self)

    async def run_while(self, baud: int) -> None:
        """Let the probe do its work until it wants another rate, or is done."""
        probe = self._probe
        while probe.result is None and probe.baud == baud and self.failure is None:
            self._send()
            due_s = probe.get_timer()
            self._stirred.clear()
            try:
                async with asyncio.timeout_at(due_s):
                    await self._stirred.wait()
            except TimeoutError:
                probe.handle_timer(self._loop.time())

    def data_received(self, data: bytes) -> None:
        """Take a chunk from the port."""
        self._probe.receive_data(data, self._loop.time())
        self._send()
        self._stirred.set()

    def connection_lost(self, error: TransportError | None) -> None:
        """Learn that the port has gone."""
        self.failure = error or TransportOpenError("the port was closed; plug the board in again")
        self._stirred.set()

    def pause_writing(self) -> None:
        """A topic request is a few bytes."""

    def resume_writing(self) -> None:
        """As above."""

    def _send(self) -> None:
        data = self._probe.data_to_send()
        if data and self._transport is not None:
            self._transport.write(data)

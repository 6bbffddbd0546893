"""Drives one DeviceLink over the current transport: bytes, timers and writes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from rostether.errors import TransportError
from rostether.rosserial.device_link import DeviceLink
from rostether.rosserial.events import DeviceEvent
from rostether.transports.transport import Transport

# On a slow line, a longer queue would only delay every message, so new ones are rejected. At 57600 baud this
# is three seconds.
MAX_BACKLOG_BYTES = 16 * 1024


class DeviceLine:
    """The receiver of a device's transports, one after the other."""

    def __init__(
        self,
        link: DeviceLink,
        on_event: Callable[[DeviceEvent], None],
        on_lost: Callable[[], None],
        clock: Callable[[], float],
    ) -> None:
        self._link = link
        self._on_event = on_event
        self._on_lost = on_lost
        self._clock = clock
        self._loop = asyncio.get_running_loop()
        self._transport: Transport | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._is_flush_scheduled = False
        self._writable = asyncio.Event()
        self._lost = asyncio.Event()
        self._error: TransportError | None = None

    @property
    def transport(self) -> Transport | None:
        """The transport in use."""
        return self._transport

    def attach(self, transport: Transport) -> None:
        """Start on a new transport."""
        self._transport = transport
        self._error = None
        self._lost.clear()
        self._writable.set()
        self._link.start(self._clock())
        transport.start(self)
        self.flush()

    def detach(self) -> None:
        """Detach from the transport and close it."""
        transport, self._transport = self._transport, None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._lost.set()
        self._writable.set()
        if transport is not None:
            transport.close()

    async def wait_lost(self) -> TransportError | None:
        """Wait until the transport has ended; return the error, None without one."""
        await self._lost.wait()
        return self._error

    async def wait_writable(self) -> None:
        """Wait until the transport accepts more bytes."""
        await self._writable.wait()

    def publish(self, topic_id: int, payloads: Sequence[bytes]) -> bool:
        """Send messages with the next flush; return False if no host is connected or the line is full."""
        transport = self._transport
        if transport is None or transport.write_buffer_bytes > MAX_BACKLOG_BYTES:
            return False
        sent = self._link.publish(topic_id, payloads)
        self.flush_soon()
        return sent

    def flush_soon(self) -> None:
        """Write all data that is queued in this iteration of the event loop with one call."""
        if not self._is_flush_scheduled:
            self._is_flush_scheduled = True
            self._loop.call_soon(self._flush_scheduled_bytes)

    def flush(self) -> None:
        """Write the link's output, and set its timer."""
        if self._transport is None:
            return
        if self._writable.is_set():
            data = self._link.data_to_send()
            if data:
                self._transport.write(data)
        self._set_timer()

    def handle_timer(self) -> None:
        """Handle the link's timer, which is due."""
        if self._transport is not None:
            self._timer = None
            self._report(self._link.handle_timer(self._clock()))

    def data_received(self, data: bytes) -> None:
        """Handle a chunk from the host."""
        if self._transport is not None:
            self._report(self._link.receive_data(data, self._clock()))

    def connection_lost(self, error: TransportError | None) -> None:
        """Handle the end of the transport."""
        if self._transport is None:
            return
        self._error = error
        self.detach()
        self._on_lost()

    def pause_writing(self) -> None:
        """Keep data in the link until `resume_writing`; the link refuses messages if it has too many."""
        self._writable.clear()

    def resume_writing(self) -> None:
        """Write again."""
        self._writable.set()
        self.flush()

    def _report(self, events: Sequence[DeviceEvent]) -> None:
        for event in events:
            self._on_event(event)
        self.flush()

    def _flush_scheduled_bytes(self) -> None:
        self._is_flush_scheduled = False
        self.flush()

    def _set_timer(self) -> None:
        due_s = self._link.get_timer()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if due_s is not None:
            delay_s = max(0.0, due_s - self._clock())
            self._timer = self._loop.call_later(delay_s, self.handle_timer)

"""Serial ports through serialx: opening, the data path, and the list of ports.

Importing this module costs 50 ms, so other modules import it only inside functions.
"""

from __future__ import annotations

import asyncio
import contextlib
from typing import cast

import serialx

from rostether.errors import TransportClosedError, TransportError
from rostether.transports.address import SerialAddress
from rostether.transports.serial_errors import explain_open_error, is_pseudo_terminal
from rostether.transports.serial_port import SerialPort, find_usb_location
from rostether.transports.sockets import explain_reason
from rostether.transports.stream import FLUSH_LIMIT_S, READ_CHUNK_BYTES, StreamTransport

# A pseudo-terminal has no baud rate, and some systems refuse to set unusual ones on it.
_PTY_BAUD = 115200
# How often `close` checks whether the port's output buffer is empty.
_FLUSH_POLL_S = 0.02


def list_ports() -> list[SerialPort]:
    """Return the current serial ports, sorted by path."""
    ports = [
        SerialPort(
            path=info.resolved_device,
            description=_describe(info),
            by_id=info.device if info.device != info.resolved_device else None,
            usb_vendor_id=info.vid,
            usb_product_id=info.pid,
            serial_number=info.serial_number,
            manufacturer=info.manufacturer,
            usb_location=find_usb_location(info.resolved_device),
            usb_interface=info.interface_num,
        )
        for info in serialx.list_serial_ports()
    ]
    return sorted(ports, key=lambda port: port.path)


async def open_serial(address: SerialAddress) -> SerialTransport:
    """Open a port exclusively. Raises TransportOpenError, ConfigError for an unsupported baud rate.

    Linux asserts DTR whenever a port is opened; with `reset=False` it stays asserted at close. Then the next
    openings change nothing on the line, and the board keeps running.
    """
    is_pty = is_pseudo_terminal(address.path)
    transport = SerialTransport(address.path, is_pty=is_pty)
    loop = asyncio.get_running_loop()
    on_open = serialx.PinState.HIGH if address.reset else serialx.PinState.UNDEFINED
    on_close = serialx.PinState.LOW if address.reset else serialx.PinState.UNDEFINED
    try:
        await serialx.create_serial_connection(
            loop,
            lambda: transport,
            address.path,
            baudrate=_PTY_BAUD if is_pty else address.baud,
            close_timeout=FLUSH_LIMIT_S,
            dtr_on_open=on_open,
            rts_on_open=on_open,
            dtr_on_close=on_close,
            rts_on_close=on_close,
        )
    except (OSError, serialx.SerialException, ValueError) as error:
        # Runs in a thread, because the explanation reads /proc and /sys.
        raise await asyncio.to_thread(explain_open_error, address, error, list_ports) from error
    return transport


class SerialTransport(StreamTransport, asyncio.Protocol):
    """An open serial port or pseudo-terminal; made by `open_serial`."""

    def __init__(self, path: str, *, is_pty: bool) -> None:
        super().__init__(path, can_pause=is_pty)
        self._drain_timer: asyncio.TimerHandle | None = None

    @property
    def has_baud(self) -> bool:
        """Whether the line has a baud rate: a pseudo-terminal has none."""
        return not self.can_pause

    def set_baud(self, baud: int) -> bool:
        """Change the baud rate, and drop unread bytes; return False if the port does not support it."""
        port = self._port()
        if port is None or not self.has_baud:
            return True
        try:
            port.reconfigure_port(baudrate=baud)
            port.reset_read_buffer()
        except (OSError, serialx.SerialException, ValueError):
            return False
        return True

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep asyncio's transport; reading waits for `start`."""
        # serialx reads 256 KiB each time, and the buffer costs 30 µs, but a terminal never has so much.
        if hasattr(transport, "max_size"):
            transport.max_size = READ_CHUNK_BYTES
        super().connection_made(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        """Pass on the end of the port, once."""
        if self._drain_timer is not None:
            self._drain_timer.cancel()
        super().connection_lost(exc)

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that are still waiting, including those in the operating system."""
        return super().write_buffer_bytes + (0 if self._is_lost else self._unsent_bytes())

    def data_received(self, data: bytes) -> None:
        """Deliver received bytes."""
        self._deliver(data)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended."""
        # The port was unplugged between two wake-ups: serialx raises here, and also calls connection_lost.
        with contextlib.suppress(OSError, RuntimeError):
            super().write(data)

    def abort(self) -> None:
        """Close immediately; queued data is lost. Idempotent."""
        port = self._port()
        if port is not None:
            with contextlib.suppress(OSError):
                port.reset_write_buffer()
        super().abort()

    def _end_wire(self, wire: asyncio.Transport) -> None:
        wire.pause_reading()
        self._close_when_drained(wire)

    def _close_when_drained(self, wire: asyncio.Transport) -> None:
        # The kernel's close waits up to 30 s for a board that accepts nothing, so it is called when the bytes
        # have left; `abort` drops them when the time limit passes.
        if wire.get_write_buffer_size() or self._unsent_bytes():
            loop = asyncio.get_running_loop()
            self._drain_timer = loop.call_later(_FLUSH_POLL_S, self._close_when_drained, wire)
        else:
            wire.close()

    def _unsent_bytes(self) -> int:
        port = self._port()
        try:
            return port.num_unwritten_bytes() if port is not None else 0
        except OSError:
            return 0

    def _port(self) -> serialx.BaseSerial | None:
        """Return the port unless it is being closed: its descriptor may already belong to another file."""
        if self._wire is None or self._is_lost or self._wire.is_closing():
            return None
        return cast("serialx.BaseSerialTransport", self._wire).serial

    def _explain_loss(self, exc: Exception | None) -> TransportError:
        reason = f" ({explain_reason(exc)})" if exc is not None else ""
        return TransportClosedError(f"{self.peer} is gone{reason}; plug the board in again")


def _describe(info: serialx.SerialPortInfo) -> str:
    product = info.product or ""
    if info.manufacturer and not product.startswith(info.manufacturer):
        product = f"{info.manufacturer} {product}".strip()
    if info.interface_description and info.interface_description not in product:
        product = f"{product} ({info.interface_description})".strip()
    return product or "serial port"

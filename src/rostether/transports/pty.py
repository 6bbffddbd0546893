"""A pseudo-terminal with a symbolic link, which a simulated board opens like a serial port.

The terminal stays while programs open and close the other side. While no program has it open, Linux reports
a hang-up all the time: instead of watching it, the event loop then checks it twenty times a second. Bytes
that are written in the meantime are dropped, so that the next program receives no old data.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import sys
from collections.abc import Iterator
from pathlib import Path

from rostether.errors import ConfigError, TransportOpenError
from rostether.transports.address import PtyAddress
from rostether.transports.pty_link import PtyLink
from rostether.transports.sockets import explain_reason
from rostether.transports.stream import FLUSH_LIMIT_S
from rostether.transports.transport import HIGH_WATER_BYTES, LOW_WATER_BYTES, PausingTransport, Receiver

# Users do not notice this delay, and the checks cost less than 0.1 % of a CPU.
_OPENER_POLL_S = 0.05
# The kernel drops unread bytes when our side closes, and moves bytes to the reader in steps: all bytes are
# read when two checks in a row find none waiting.
_UNREAD_POLL_S = 0.01
_UNREAD_CHECKS = 2
# Linux delivers at most 4 KiB, or a flip buffer of 16 KiB, at once; larger buffers only need memory.
_READ_BYTES = 16 * 1024


def open_pty(address: PtyAddress) -> PtyTransport:
    """Create a pseudo-terminal and its link. Raises TransportOpenError, ConfigError on Windows."""
    if sys.platform == "win32":
        raise ConfigError(
            f"{address} needs pseudo-terminals, which Windows does not have; use tcp://:11411 there"
        )
    import tty  # Windows lacks this module

    link = PtyLink(Path(address.link))
    try:
        master, slave = os.openpty()
    except OSError as error:
        raise TransportOpenError(
            f"cannot create a pseudo-terminal: {explain_reason(error)}; close programs that use many of them"
        ) from error
    try:
        terminal = os.ttyname(slave)
        tty.setraw(slave)
        os.set_blocking(master, False)
        link.place(terminal)
    except OSError as error:
        os.close(master)
        raise TransportOpenError(
            f"cannot link a pseudo-terminal at {address.link}: {explain_reason(error)}; choose another path"
        ) from error
    finally:
        os.close(slave)
    return PtyTransport(master, terminal, link)


class PtyTransport(PausingTransport):
    """Our side of a pseudo-terminal; created by `open_pty`. The link points to `terminal`."""

    # A full terminal blocks its writer.
    can_pause = True

    def __init__(self, master: int, terminal: str, link: PtyLink) -> None:
        super().__init__()
        self._loop = asyncio.get_running_loop()
        self._master = master
        self.terminal = terminal
        self._link = link
        self._wants_reading = True
        self._is_reading = False
        self._is_open = False
        self._timer: asyncio.TimerHandle | None = None
        self._poll = select.poll()
        self._poll.register(master, select.POLLIN)
        self._unsent = bytearray()
        self._is_closing = False
        self._ended = asyncio.Event()
        self._flush_limit: asyncio.TimerHandle | None = None
        self._check_for_opener()

    @property
    def peer(self) -> str:
        """The other side's name for users."""
        return f"pty {self._link.path}"

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that are still waiting."""
        return len(self._unsent)

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once. Bytes received earlier are kept."""
        self._receiver = receiver
        if self._ended.is_set():
            self._loop.call_soon(receiver.connection_lost, None)
            return
        if self._is_writing_paused:
            receiver.pause_writing()
        self._apply_reading()

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; drops them while no program has the terminal open."""
        if self._is_closing or not self._is_open:
            return
        if not self._unsent:
            sent = self._send(data)
            if sent == len(data) or not self._is_open:
                return
            data = memoryview(data)[sent:]
            self._loop.add_writer(self._master, self._write_ready)
        self._unsent += data
        if not self._is_writing_paused and len(self._unsent) > HIGH_WATER_BYTES:
            self.pause_writing()

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""
        self._wants_reading = False
        self._apply_reading()

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""
        self._wants_reading = True
        self._apply_reading()

    def close(self) -> None:
        """Flush queued data for at most a second, then close and remove the link. Idempotent."""
        if self._is_closing:
            return
        self._is_closing = True
        self._apply_reading()
        if not self._is_open:
            self._end()
            return
        self._flush_limit = self._loop.call_later(FLUSH_LIMIT_S, self._end)
        if not self._unsent:
            self._end_when_read()

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""
        await self._ended.wait()

    def _apply_reading(self) -> None:
        wanted = self._wants_reading and self._is_open and self._receiver is not None and not self._is_closing
        if wanted and not self._is_reading:
            self._loop.add_reader(self._master, self._read_ready)
        elif self._is_reading and not wanted:
            self._loop.remove_reader(self._master)
        self._is_reading = wanted

    def _read_ready(self) -> None:
        try:
            data = os.read(self._master, _READ_BYTES)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if data and self._receiver is not None:
            self._receiver.data_received(data)
        elif not data:
            self._hung_up()

    def _write_ready(self) -> None:
        sent = self._send(self._unsent)
        if not self._is_open:
            return
        if not sent and self._has_event(select.POLLHUP):
            self._hung_up()
            return
        del self._unsent[:sent]
        if not self._unsent:
            self._loop.remove_writer(self._master)
            if self._is_closing:
                self._end_when_read()
                return
        self._resume_when_drained()

    def _send(self, data: bytes | bytearray | memoryview) -> int:
        try:
            return os.write(self._master, data)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError:
            self._hung_up()
            return 0

    def _resume_when_drained(self) -> None:
        is_low = len(self._unsent) <= LOW_WATER_BYTES
        if self._is_writing_paused and is_low and not self._is_closing:
            self.resume_writing()

    def _hung_up(self) -> None:
        """Forget the program that closed the terminal, with all its unread bytes."""
        if not self._is_open:
            return
        self._is_open = False
        if self._unsent:
            self._loop.remove_writer(self._master)
            self._unsent.clear()
        self._apply_reading()
        if self._is_closing:
            self._end()
            return
        self._resume_when_drained()
        _discard_unread(self.terminal)
        self._check_for_opener()

    def _check_for_opener(self) -> None:
        # Unread bytes mean that a program was connected between two checks.
        self._is_open = not self._has_event(select.POLLHUP) or self._has_event(select.POLLIN)
        if self._is_open:
            self._timer = None
            self._apply_reading()
        else:
            self._timer = self._loop.call_later(_OPENER_POLL_S, self._check_for_opener)

    def _has_event(self, kind: int) -> bool:
        return any(event & kind for _, event in self._poll.poll(0))

    def _end_when_read(self, checks_left: int = _UNREAD_CHECKS) -> None:
        checks_left = _UNREAD_CHECKS if _count_unread(self.terminal) else checks_left - 1
        if checks_left:
            self._timer = self._loop.call_later(_UNREAD_POLL_S, self._end_when_read, checks_left)
        else:
            self._end()

    def _end(self) -> None:
        if self._ended.is_set():
            return
        self._ended.set()
        for timer in (self._timer, self._flush_limit):
            if timer is not None:
                timer.cancel()
        if self._unsent:
            self._loop.remove_writer(self._master)
            self._unsent.clear()
        os.close(self._master)
        self._link.remove()
        if self._receiver is not None:
            self._loop.call_soon(self._receiver.connection_lost, None)


@contextlib.contextmanager
def _slave(terminal: str) -> Iterator[int]:
    slave = os.open(terminal, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        yield slave
    finally:
        os.close(slave)


def _discard_unread(terminal: str) -> None:
    import termios

    with contextlib.suppress(OSError, termios.error), _slave(terminal) as slave:
        termios.tcflush(slave, termios.TCIFLUSH)


def _count_unread(terminal: str) -> int:
    import fcntl
    import termios

    with contextlib.suppress(OSError), _slave(terminal) as slave:
        return int.from_bytes(fcntl.ioctl(slave, termios.FIONREAD, bytes(4)), sys.byteorder)
    return 0

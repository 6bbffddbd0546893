"""Writes captures outside the data path: collects the bytes of links, and writes them periodically."""

from __future__ import annotations

import asyncio
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path

from rostether.errors import ConfigError, TransportError
from rostether.mechanisms.text import write_failure
from rostether.transports.capture import FIRST_LINK
from rostether.transports.transport import PausingTransport, Receiver, Transport

# An hour of a full line at 115200 baud: small enough to send when compressed, and to fit on any disk.
DEFAULT_LIMIT_BYTES = 100 << 20

# A killed process loses the data of this time; a shorter period would cost a system call for each chunk.
FLUSH_PERIOD_S = 0.2

# If more than this is collected, it is written before the period ends.
FLUSH_BYTES = 256 * 1024

# The braces and keys around a chunk's bytes.
_OVERHEAD_BYTES = 64


class CaptureWriter:
    """Writes one capture. If it must end early (size limit, disk error), `report` gets one line.

    Raises ConfigError if the file exists or cannot be written.
    """

    def __init__(
        self,
        path: Path,
        *,
        clock: Callable[[], float],
        description: Mapping[str, object],
        limit_bytes: int = DEFAULT_LIMIT_BYTES,
        report: Callable[[str], None],
    ) -> None:
        self.path = path
        self.written_bytes = 0
        self._clock = clock
        self._limit_bytes = limit_bytes
        self._report = report
        self._links = FIRST_LINK - 1
        self._noted: list[tuple[float, int, str, bytes]] = []
        self._noted_bytes = 0
        self._timer: asyncio.TimerHandle | None = None
        try:
            # The mode never replaces another capture; without a buffer, a killed process leaves no half line.
            self._file: int | None = os.open(
                path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o644
            )
        except FileExistsError:
            raise ConfigError(f"{path} already exists; give another file") from None
        except OSError as error:
            raise ConfigError(write_failure(path, error)) from error
        self._start_s = clock()
        self._write(json.dumps({"capture": path.stem, **description}).encode() + b"\n")

    def tap(self, transport: Transport) -> Transport:
        """Return a transport that records all its data as a separate link."""
        self._links += 1
        recorded = RecordedTransport(transport, self, self._links)
        self._note_event(self._links, {"event": "opened", "peer": transport.peer})
        return recorded

    def note(self, link: int, side: str, data: bytes) -> None:
        """Record data of a link."""
        if self._file is None:
            return
        self._noted.append((self._clock(), link, side, data))
        self._noted_bytes += 2 * len(data) + _OVERHEAD_BYTES
        if self._noted_bytes >= FLUSH_BYTES:
            self.flush()
        elif self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(FLUSH_PERIOD_S, self.flush)

    def note_closed(self, link: int, error: TransportError | None) -> None:
        """Record the end of a link."""
        self._note_event(link, {"event": "closed"} | ({"why": str(error)} if error is not None else {}))

    def flush(self) -> None:
        """Write the collected lines."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        noted, self._noted = self._noted, []
        self._noted_bytes = 0
        lines: list[bytes] = []
        for time_s, link, side, data in noted:
            of_link = "" if link == FIRST_LINK else f',"link":{link}'
            line = f'{{"t":{time_s - self._start_s:.6f},"from":"{side}","hex":"{data.hex()}"{of_link}}}\n'
            lines.append(line.encode())
        self._write_within_limit(lines)

    def close(self) -> None:
        """Write the rest and close the file. Idempotent."""
        self.flush()
        self._end(None)

    def _note_event(self, link: int, event: Mapping[str, object]) -> None:
        self.flush()
        time_s = round(self._clock() - self._start_s, 6)
        of_link = {} if link == FIRST_LINK else {"link": link}
        self._write_within_limit([json.dumps({"t": time_s, **event, **of_link}).encode() + b"\n"])

    def _write_within_limit(self, lines: list[bytes]) -> None:
        size = self.written_bytes
        for number, line in enumerate(lines):
            size += len(line)
            if size > self._limit_bytes:
                self._write(b"".join(lines[:number]))
                reached = f"{self.path} has reached {self._limit_bytes / (1 << 20):.3g} MB"
                self._end(f"{reached}: the recording has stopped; raise --record-limit")
                return
        self._write(b"".join(lines))

    def _write(self, data: bytes) -> None:
        if self._file is None:
            return
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._file, view) :]
        except OSError as error:
            self._end(f"the recording has stopped: {write_failure(self.path, error)}")
            return
        self.written_bytes += len(data)

    def _end(self, reason: str | None) -> None:
        if self._file is None:
            return
        os.close(self._file)
        self._file = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if reason is not None:
            self._report(reason)


class RecordedTransport(PausingTransport):
    """A transport whose bytes are recorded; created by `CaptureWriter.tap`."""

    def __init__(self, inner: Transport, writer: CaptureWriter, link: int) -> None:
        super().__init__()
        self.peer, self.remote = inner.peer, inner.remote
        self.proof, self.can_pause = inner.proof, inner.can_pause
        self._inner = inner
        self._writer = writer
        self._link = link
        self._has_ended = False

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that are still waiting."""
        return self._inner.write_buffer_bytes

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once. Bytes received earlier are kept."""
        self._receiver = receiver
        self._inner.start(self)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended."""
        if not self._has_ended:
            self._writer.note(self._link, "host", bytes(data))
        self._inner.write(data)

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""
        self._inner.pause_reading()

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""
        self._inner.resume_reading()

    def close(self) -> None:
        """Flush queued data for at most a second, then close. Idempotent."""
        self._inner.close()
        self._end(None)

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""
        await self._inner.wait_closed()

    def data_received(self, data: bytes) -> None:
        """Handle a chunk from the inner transport."""
        if not self._has_ended:
            self._writer.note(self._link, "device", data)
        if self._receiver is not None:
            self._receiver.data_received(data)

    def connection_lost(self, error: TransportError | None) -> None:
        """Handle the end of the inner transport."""
        self._end(error)
        if self._receiver is not None:
            self._receiver.connection_lost(error)

    def _end(self, error: TransportError | None) -> None:
        if not self._has_ended:
            self._has_ended = True
            self._writer.note_closed(self._link, error)

"""Boards on real lines and a bridge that serves them, for tests of faults of the line."""

from __future__ import annotations

import asyncio
import contextlib
import os
import struct
import tty
from collections.abc import AsyncIterator, Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.graph.memory_network import MemoryNetwork
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.host_output import PROBE
from rostether.rosserial.packets import TopicInfo
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from unit.bridge.nodes import STORE, topic_info
from unit.bridge.raw_board import TOPIC_REQUEST
from waiting import until

COUNT = "std_msgs/UInt32"
TIME_REQUEST = encode_frame(ids.TIME, bytes(8))


def numbered(number: int, topic_id: int = 125) -> bytes:
    """Return the frame of a message with a number."""
    return encode_frame(topic_id, struct.pack("<I", number))


class Bridge:
    """A supervisor that serves links (by default a TCP listener), and a graph with a subscriber."""

    def __init__(self, settings: BridgeSettings | None = None, *links: str) -> None:
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.supervisor = Supervisor(
            self.network.join, STORE, reporter=self.reporter, settings=settings or BridgeSettings()
        )
        self._links = links or ("tcp://127.0.0.1:0?ns=/",)
        self.port = 0

    async def __aenter__(self) -> Self:
        await self.supervisor.start([parse_address(link) for link in self._links])
        for place in self.supervisor.listening_on:
            self.port = int(place.rpartition(":")[2])
        self.peer = await self.network.join("/peer")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.supervisor.close()
        await self.peer.close()

    async def listen(self, topic: str) -> list[int]:
        """Subscribe to a topic; return the list of the received numbers."""
        received: list[int] = []

        def take(payloads: Sequence[bytes]) -> None:
            for payload in payloads:
                assert len(payload) == 4, f"{topic} delivered what does not fit its type: {payload!r}"
                received.append(struct.unpack("<I", payload)[0])

        await self.peer.subscribe(topic, STORE.registry.message_type(COUNT), take)
        return received


class Board:
    """A board that, unless it is mute, answers topic requests with its announcements.

    Before the first request of a connection, it answers probes with a time request, like boards after a
    reset.
    """

    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter

    def __init__(self, *announcements: tuple[int, TopicInfo]) -> None:
        self.announcements = announcements or (
            (ids.PUBLISHER, topic_info("count", COUNT, topic_id=125, buffer_size=512)),
        )
        self.requests = 0
        self.is_mute = False
        self.number = 0
        self.chatter: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        await self.connect()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.hang_up()

    async def connect(self, first: bytes = b"") -> None:
        """Connect; `first` is sent before anything else."""
        await self._open()
        if first:
            await self.send(first)
        self._answering = asyncio.create_task(self._answer())

    async def _open(self) -> None:
        """Set reader and writer."""
        raise NotImplementedError

    async def hang_up(self) -> None:
        """Stop sending and close the connection."""
        await self.fall_silent()
        self._answering.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._answering
        self.writer.close()
        with contextlib.suppress(OSError):
            await self.writer.wait_closed()

    async def fall_silent(self) -> None:
        """Send no more numbers; `number` is the next one."""
        chatter, self.chatter = self.chatter, None
        if chatter is not None:
            chatter.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await chatter

    async def send(self, data: bytes) -> None:
        """Send bytes as fast as the bridge reads them."""
        self.writer.write(data)
        await self.writer.drain()

    def count_from(self, first: int, *, period_s: float = 0.02) -> None:
        """Send numbers every `period_s` in a new task."""
        self.chatter = asyncio.create_task(self._count(first, period_s))

    async def settle(self, received: list[int], first: int = 0) -> None:
        """Send a number until the bridge forwards it: from then on, the board is known and has a
        subscriber.
        """

        async def speak() -> None:
            while True:
                await self.send(numbered(first))
                await asyncio.sleep(0.01)

        speaking = asyncio.create_task(speak())
        await until(lambda: first in received, "the first message")
        speaking.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await speaking
        await asyncio.sleep(0.3)  # the second round of the negotiation

    async def _count(self, first: int, period_s: float) -> None:
        self.number = first
        while True:
            self.number += 1
            await self.send(numbered(self.number - 1))
            await asyncio.sleep(period_s)

    async def _answer(self) -> None:
        unread = b""
        is_configured = False
        while data := await self.reader.read(65536):
            unread = (unread + data)[-65536:]
            if not (is_configured or self.is_mute) and PROBE in unread.replace(TOPIC_REQUEST, b""):
                unread = unread.replace(PROBE, b"") if TOPIC_REQUEST not in unread else unread
                await self.send(TIME_REQUEST)
            while TOPIC_REQUEST in unread:
                unread = unread.partition(TOPIC_REQUEST)[2]
                self.requests += 1
                is_configured = True
                if not self.is_mute:
                    burst = b"".join(encode_frame(kind, info.encode()) for kind, info in self.announcements)
                    await self.send(TIME_REQUEST + burst)


class TcpBoard(Board):
    """A board on the network."""

    def __init__(self, port: int, *announcements: tuple[int, TopicInfo]) -> None:
        super().__init__(*announcements)
        self._port = port

    async def _open(self) -> None:
        self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self._port)


class PtyBoard(Board):
    """A board that opens the pseudo-terminal that the bridge has created at a path."""

    def __init__(self, path: Path, *announcements: tuple[int, TopicInfo]) -> None:
        super().__init__(*announcements)
        self._path = path

    async def _open(self) -> None:
        await until(self._path.exists, "the bridge's terminal")
        await self._use(os.open(self._path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))

    async def _use(self, descriptor: int) -> None:
        loop = asyncio.get_running_loop()
        self.reader = asyncio.StreamReader()
        reading: BinaryIO = os.fdopen(descriptor, "rb", 0)
        writing: BinaryIO = os.fdopen(os.dup(descriptor), "wb", 0)
        self._incoming, _ = await loop.connect_read_pipe(
            lambda: asyncio.StreamReaderProtocol(self.reader), reading
        )
        outgoing, protocol = await loop.connect_write_pipe(
            lambda: asyncio.StreamReaderProtocol(asyncio.StreamReader()), writing
        )
        self.writer = asyncio.StreamWriter(outgoing, protocol, self.reader, loop)

    async def hang_up(self) -> None:
        """Stop sending and close the terminal."""
        await super().hang_up()
        self._incoming.close()


class SerialBoard(PtyBoard):
    """A board whose serial port exists at a path while the board is plugged in."""

    async def _open(self) -> None:
        near, far = os.openpty()
        tty.setraw(far)
        self._path.symlink_to(os.ttyname(far))
        os.set_blocking(near, False)
        # A terminal that no process has open reports a hang-up: it stays open until the bridge has opened it.
        self._far = far
        await self._use(near)

    async def hang_up(self) -> None:
        """Unplug."""
        self._path.unlink(missing_ok=True)
        await super().hang_up()
        with contextlib.suppress(OSError):
            os.close(self._far)


@contextlib.asynccontextmanager
async def line(
    kind: str, folder: Path, *announcements: tuple[int, TopicInfo]
) -> AsyncIterator[tuple[Bridge, Board]]:
    """Serve one link: "tcp", "pty" (of the bridge) or "serial" (a port); its board is not connected."""
    if kind == "tcp":
        async with Bridge() as bridge:
            yield bridge, TcpBoard(bridge.port, *announcements)
    elif kind == "pty":
        async with Bridge(None, f"pty:{folder}/board?ns=/") as bridge:
            yield bridge, PtyBoard(folder / "board", *announcements)
    else:
        async with Bridge(None, f"{folder}/ttyBOARD?ns=/") as bridge:
            yield bridge, SerialBoard(folder / "ttyBOARD", *announcements)


def gone_missing(received: list[int], sent: range, is_damaged: Callable[[int], bool]) -> list[int]:
    """Return the numbers that were sent undamaged and not received."""
    return sorted({number for number in sent if not is_damaged(number)} - set(received))

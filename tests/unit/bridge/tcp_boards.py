"""Boards on real TCP links and a bridge that serves them, for tests that break the line in every way."""

from __future__ import annotations

import asyncio
import contextlib
import struct
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Self

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.graph.memory_network import MemoryNetwork
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import TopicInfo
from rostether.transports.address import parse_address
from unit.bridge.doubles import RecordingReporter, until
from unit.bridge.nodes import STORE, topic_info
from unit.bridge.raw_board import TOPIC_REQUEST

COUNT = "std_msgs/UInt32"
TIME_REQUEST = encode_frame(ids.TIME, bytes(8))


def numbered(number: int, topic_id: int = 125) -> bytes:
    """Return the frame of a message that is a number."""
    return encode_frame(topic_id, struct.pack("<I", number))


class Bridge:
    """A supervisor that listens on TCP, and a graph in memory where all that comes is heard."""

    def __init__(self, settings: BridgeSettings | None = None) -> None:
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.supervisor = Supervisor(
            self.network.join, STORE, reporter=self.reporter, settings=settings or BridgeSettings()
        )
        self.port = 0

    async def __aenter__(self) -> Self:
        await self.supervisor.start([parse_address("tcp://127.0.0.1:0?ns=/")])
        self.port = int(self.supervisor.listening_on[0].rpartition(":")[2])
        self.peer = await self.network.join("/peer")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.supervisor.close()
        await self.peer.close()

    async def listen(self, topic: str) -> list[int]:
        """Return a list that gets the number of every message of a topic."""
        heard: list[int] = []

        def take(payloads: Sequence[bytes]) -> None:
            for payload in payloads:
                assert len(payload) == 4, f"{topic} delivered what does not fit its type: {payload!r}"
                heard.append(struct.unpack("<I", payload)[0])

        await self.peer.subscribe(topic, STORE.registry.message_type(COUNT), take)
        return heard


class TcpBoard:
    """One board; it answers topic requests with its announcements, as long as it is not `mute`."""

    def __init__(self, port: int, *announcements: tuple[int, TopicInfo]) -> None:
        self._port = port
        self.announcements = announcements or (
            (ids.PUBLISHER, topic_info("count", COUNT, topic_id=125, buffer_size=512)),
        )
        self.requests = 0
        self.is_mute = False
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
        self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self._port)
        if first:
            await self.send(first)
        self._answering = asyncio.create_task(self._answer())

    async def hang_up(self) -> None:
        """Stop speaking and end the connection."""
        for task in (self.chatter, self._answering):
            if task is not None:
                task.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await task
        self.chatter = None
        self.writer.close()
        with contextlib.suppress(OSError):
            await self.writer.wait_closed()

    async def send(self, data: bytes) -> None:
        """Send bytes, at the pace at which the bridge reads them."""
        self.writer.write(data)
        await self.writer.drain()

    def count_from(self, first: int, *, period_s: float = 0.02) -> None:
        """Send numbers from now on, each `period_s`, in a task of its own."""
        self.chatter = asyncio.create_task(self._count(first, period_s))

    async def settle(self, heard: list[int], first: int = 0) -> None:
        """Send a number until the bridge passes it on: from then on it is known and subscribed."""

        async def speak() -> None:
            while True:
                await self.send(numbered(first))
                await asyncio.sleep(0.01)

        speaking = asyncio.create_task(speak())
        await until(lambda: first in heard, "the first message")
        speaking.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await speaking
        await asyncio.sleep(0.3)  # the second round of the negotiation

    async def _count(self, number: int, period_s: float) -> None:
        while True:
            await self.send(numbered(number))
            number += 1
            await asyncio.sleep(period_s)

    async def _answer(self) -> None:
        unread = b""
        while data := await self.reader.read(65536):
            unread = (unread + data)[-65536:]
            while TOPIC_REQUEST in unread:
                unread = unread.partition(TOPIC_REQUEST)[2]
                self.requests += 1
                if not self.is_mute:
                    burst = b"".join(encode_frame(kind, info.encode()) for kind, info in self.announcements)
                    await self.send(TIME_REQUEST + burst)


def gone_missing(heard: list[int], sent: range, is_damaged: Callable[[int], bool]) -> list[int]:
    """Return the numbers that were sent whole and not heard."""
    return sorted({number for number in sent if not is_damaged(number)} - set(heard))

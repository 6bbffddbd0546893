"""The host's side of a check: sends bytes to the client under test, and waits for its answers.

It uses the frame and packet codecs, but not the bridge's tolerance: the cases choose every byte. Requests for
the time are answered, unless a case suppresses the answers.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from rostether.conformance.program import PREFIX, Part
from rostether.conformance.received_frame import (
    Announcement,
    Deviation,
    Frame,
    is_announcement,
    read_announcement,
    read_text,
)
from rostether.errors import TransportError, TransportTimeoutError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.frame_decoder import FrameDecoder
from rostether.rosserial.packets import ParameterRequest, ParameterResponse, encode_time
from rostether.rostime import Time
from rostether.transports.transport import SmallWriter, Transport

# The time limit for each answer, enough for a busy or slow machine.
ANSWER_S = 8.0
# A board that the opened port resets spends up to 2 s in its bootloader; one on a network may connect late.
FIRST_ANSWER_S = 15.0
# The first request may be lost in the bootloader.
ASK_AGAIN_S = 1.0
# The announcements are complete if none follows within this time.
SETTLED_S = 0.5
# After a pause of this length inside a frame, its rest was lost. Simulated boards pause on a busy machine.
TORN_AFTER_S = 5.0
# The host's clock at the start of a check.
HOST_EPOCH = Time(1_700_000_000, 0)
# More than a client sends in a run; the rest of a flood is ignored.
MAX_KEPT_FRAMES = 100_000
# The pause after each byte that is sent alone: longer than a byte at 9600 baud.
SLOW_BYTE_S = 0.002
# The number of runs of invalid bytes that are kept for the report: a few show the fault.
MAX_KEPT_DAMAGE = 20

Connect = Callable[[], Awaitable[Transport]]


class CheckedClient(SmallWriter):
    """One client under test; `connect` opens a line to it, and another one after a line has ended.

    `announcements` are those at the start; `damage` describes invalid bytes from the client. While
    `answers_time` is true, requests for the time are answered.
    """

    def __init__(self, connect: Connect) -> None:
        self._connect = connect
        self._loop = asyncio.get_running_loop()
        self._transport: Transport | None = None
        self._decoder = FrameDecoder()
        self._arrived = asyncio.Event()
        self._began_s = self._received_at_s = self._loop.time()
        self._frames: list[Frame] = []
        self._position = 0
        self._parameters: dict[str, ParameterResponse] = {}
        self._is_configured = False
        self._is_silent = False
        self.answers_time = True
        self.announcements: list[Announcement] = []
        self.damage: list[str] = []

    async def open(self) -> None:
        """Connect, and request the topics until the client announces them.

        Raises TransportError, and TransportTimeoutError if no client announces a topic.
        """
        await self.reconnect()
        deadline_s = self._loop.time() + FIRST_ANSWER_S
        while self._loop.time() < deadline_s:
            self.send(ids.TOPIC_REQUEST)
            if await self.find(is_announcement, ASK_AGAIN_S):
                await self._collect_announcements()
                return
        raise TransportTimeoutError(
            f"no client announced a topic within {FIRST_ANSWER_S:g} s; check its address, its baud rate, and "
            "that it runs the conformance program"
        )

    async def reconnect(self) -> None:
        """Close the connection if it is open, and open it again. Raises TransportError."""
        await self.close()
        self._decoder = FrameDecoder()
        self._is_configured = False
        self._transport = await self._connect()
        self._transport.start(self)

    async def close(self) -> None:
        """Close the connection."""
        transport, self._transport = self._transport, None
        if transport is not None:
            transport.close()
            await transport.wait_closed()

    async def prepare(self) -> None:
        """Bring the client into the initial state of a case: configured, with no unread data.

        Raises Deviation if it does not answer even on a new connection, TransportError if the connection is
        lost and cannot be opened again.
        """
        self.answers_time = True
        self._parameters.clear()
        if self._transport is None:
            await self.reconnect()
        if not self._is_configured:
            await self._recover()
        self.skip()

    async def _recover(self) -> None:
        try:
            await self.configure(tries=1 if self._is_silent else 3)
        except Deviation:
            if self._is_silent:
                raise
            # A client that ignores a second request answers the first one on a new connection.
            self._is_silent = True
            await self.reconnect()
            await self.configure()

    async def configure(self, tries: int = 3) -> list[Announcement]:
        """Request the topics up to `tries` times; return the announcements, which may be fewer than at first.

        Raises Deviation if there are none.
        """
        known = len(self.announcements)
        self.skip()
        # A client that waits for the rest of a damaged frame drops it within this time.
        for _ in range(tries):
            self.send(ids.TOPIC_REQUEST)
            if await self.find(is_announcement, ANSWER_S / 2):
                break
        else:
            raise Deviation("no announcement followed a topic request")
        self._position -= 1
        found: list[Announcement] = []
        while len(found) < known and (frame := await self.find(is_announcement, ANSWER_S / 2)):
            found.append(read_announcement(frame))
        self._is_configured, self._is_silent = True, False
        return found

    def require_configuration(self) -> None:
        """Make the next case start with a topic request."""
        self._is_configured = False

    def send(self, topic_id: int, payload: bytes = b"") -> None:
        """Send one frame."""
        self.send_bytes(encode_frame(topic_id, payload))

    def send_bytes(self, data: bytes) -> None:
        """Send bytes that need not be a frame. Raises Deviation if the connection has ended."""
        if self._transport is None:
            raise Deviation("the client closed the connection")
        self._transport.write(data)

    async def send_slowly(self, data: bytes) -> None:
        """Send bytes one by one."""
        for byte in data:
            self.send_bytes(bytes((byte,)))
            await asyncio.sleep(SLOW_BYTE_S)

    def set_parameter(self, name: str, response: ParameterResponse) -> None:
        """Answer requests for a parameter until the end of the case."""
        self._parameters[name] = response

    def skip(self) -> None:
        """Ignore the frames that have arrived."""
        self._position = len(self._frames)

    async def find(self, is_wanted: Callable[[Frame], bool], within_s: float) -> Frame | None:
        """Return the next frame that meets a condition, and continue after it; None after the time limit."""
        deadline_s = self._loop.time() + within_s
        while True:
            while self._position < len(self._frames):
                frame = self._frames[self._position]
                self._position += 1
                if is_wanted(frame):
                    return frame
            self._arrived.clear()
            try:
                async with asyncio.timeout_at(deadline_s):
                    await self._arrived.wait()
            except TimeoutError:
                return None

    async def expect(
        self, is_wanted: Callable[[Frame], bool], what: str, within_s: float = ANSWER_S
    ) -> Frame:
        """Return the next frame that meets a condition; `what` names it in errors.

        Raises Deviation if none arrives in time.
        """
        frame = await self.find(is_wanted, within_s)
        if frame is None:
            raise Deviation(f"{what} did not arrive within {within_s:g} s")
        return frame

    async def next_on(self, name: str) -> bytes:
        """Return the next message of a publisher of the program. Raises Deviation if none arrives in time."""
        topic_id = self.id_of(name)
        frame = await self.expect(lambda each: each.topic_id == topic_id, f"a message on {PREFIX}{name}")
        return frame.payload

    async def expect_text(self, wanted: str) -> None:
        """Wait for the next message on text_out. Raises Deviation if none arrives, or another text."""
        text = read_text(await self.next_on("text_out"))
        if text != wanted:
            raise Deviation(f"the client sent {text[:40]!r}, not {wanted[:40]!r}")

    def id_of(self, name: str, kind: int | None = None) -> int:
        """Return the topic id of an endpoint of the program; `kind` selects a request or response id.

        Raises Deviation if it is not announced.
        """
        for each in self.announcements:
            if each.info is not None and each.name == PREFIX + name and kind in (None, each.kind):
                return each.info.topic_id
        raise Deviation(f"{PREFIX}{name} is not announced")

    def buffer_of(self, name: str) -> int:
        """Return the maximum size in bytes of a message to a subscriber of the program."""
        (info,) = (each.info for each in self.announcements if each.info and each.name == PREFIX + name)
        return info.buffer_size

    @property
    def is_over_tcp(self) -> bool:
        """Whether the connection is over TCP, which loses no bytes."""
        transport = self._transport
        return transport is not None and transport.remote is not None and transport.can_pause

    def has(self, part: Part) -> bool:
        """Return whether the client announced all endpoints of a part, with the right types."""
        announced = {
            (each.kind, each.name, each.info.message_type) for each in self.announcements if each.info
        }
        return all(
            (kind, PREFIX + role.name, role.type) in announced
            for role in part.value
            for kind in role.announced_on
        )

    def host_time_s(self) -> float:
        """Return the host's clock, in seconds since the epoch."""
        return HOST_EPOCH.secs + self._loop.time() - self._began_s

    def time_answer(self) -> bytes:
        """Return a frame with the host's time."""
        return encode_frame(ids.TIME, encode_time(Time.from_s(self.host_time_s())))

    def data_received(self, data: bytes) -> None:
        """Read data from the client, and answer its requests."""
        now_s = self._loop.time()
        is_torn = self._decoder.pending_bytes > 0 and now_s - self._received_at_s > TORN_AFTER_S
        torn = self._decoder.abandon(now_s) if is_torn else []
        self._received_at_s = now_s
        for each in (*torn, *self._decoder.feed(data, now_s)):
            if isinstance(each, FrameDiscarded):
                if len(self.damage) < MAX_KEPT_DAMAGE:
                    self.damage.append(f"{each.reason.name.lower()}: {each.data[:16].hex(' ')}")
                continue
            for payload in each.payloads:
                if len(self._frames) < MAX_KEPT_FRAMES:
                    self._frames.append(Frame(each.topic_id, payload))
                self._answer(each.topic_id, payload)
        self._arrived.set()

    def connection_lost(self, error: TransportError | None) -> None:
        """Handle the end of the connection."""
        self._transport = None
        self._is_configured = False
        self._arrived.set()

    def _answer(self, topic_id: int, payload: bytes) -> None:
        if self._transport is None:
            return
        if topic_id == ids.TIME and self.answers_time:
            self._transport.write(self.time_answer())
        elif topic_id == ids.PARAMETER:
            request = ParameterRequest.decode(payload)
            response = self._parameters.get(request.name.lstrip("/")) if request is not None else None
            if response is not None:
                self._transport.write(encode_frame(ids.PARAMETER, response.encode()))

    async def _collect_announcements(self) -> None:
        frame: Frame | None = self._frames[self._position - 1]
        while frame is not None:
            self.announcements.append(read_announcement(frame))
            frame = await self.find(is_announcement, SETTLED_S)
        self._is_configured = True

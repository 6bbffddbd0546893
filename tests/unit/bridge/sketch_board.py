"""A board with a fault: a sketch with a wrong loop(), clock, RAM, buffers or wiring.

It receives and sends bytes at each run of its loop(), where a sketch calls spinOnce().
"""

from __future__ import annotations

import asyncio
import contextlib
import struct
from collections.abc import Callable

from rostether.errors import TransportError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import TopicInfo
from rostether.transports.transport import Transport
from unit.bridge.nodes import STORE

Turn = Callable[["SketchBoard", float], None]


class SketchBoard:
    """`turn` is the sketch's loop(), which runs every `loop_s`; the clock is `clock_ppm` too fast."""

    def __init__(
        self,
        transport: Transport,
        *,
        config: DeviceLinkConfig | None = None,
        loop_s: float = 0.005,
        clock_ppm: float = 0.0,
        reset_every_s: float | None = None,
        boot_s: float = 0.1,
        boot_text: bytes = b"",
        turn: Turn | None = None,
        garble: Callable[[bytes], bytes] = bytes,
    ) -> None:
        self.transport = transport
        self.link = DeviceLink(config)
        self.loop_s = loop_s
        self._clock_ppm = clock_ppm
        self._reset_every_s = reset_every_s
        self._boot_s = boot_s
        self._boot_text = boot_text
        self._turn = turn
        self._garble = garble
        self._inbox = bytearray()
        self._task: asyncio.Task[None] | None = None
        self.ids: dict[str, int] = {}

    def publisher(self, topic: str, type_name: str = "std_msgs/String", md5sum: str = "") -> SketchBoard:
        md5sum = md5sum or STORE.registry.message_type(type_name).md5sum
        self.ids[topic] = self.link.add_publisher(topic, type_name, md5sum)
        return self

    def subscriber(self, topic: str, type_name: str = "std_msgs/String") -> SketchBoard:
        md5sum = STORE.registry.message_type(type_name).md5sum
        self.ids[topic] = self.link.add_subscriber(topic, type_name, md5sum)
        return self

    def plug_in(self) -> SketchBoard:
        self.transport.start(self)
        self._task = asyncio.get_running_loop().create_task(self._run())
        return self

    async def unplug(self) -> None:
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        self.transport.close()

    def now_s(self) -> float:
        return asyncio.get_running_loop().time() * (1 + self._clock_ppm * 1e-6)

    def write(self, data: bytes) -> None:
        self.transport.write(self._garble(data))

    def data_received(self, data: bytes) -> None:
        self._inbox += data

    def connection_lost(self, error: TransportError | None) -> None:
        if self._task is not None:
            self._task.cancel()

    def pause_writing(self) -> None:
        pass

    def resume_writing(self) -> None:
        pass

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        booted_s = loop.time()
        self.link.start(self.now_s())
        while True:
            await asyncio.sleep(self.loop_s)
            now_s = self.now_s()
            if self._reset_every_s is not None and loop.time() - booted_s >= self._reset_every_s:
                self.write(self._boot_text)
                await asyncio.sleep(self._boot_s)
                self._inbox.clear()
                booted_s = loop.time()
                self.link.start(self.now_s())
                continue
            data, self._inbox = bytes(self._inbox), bytearray()
            self.link.receive_data(data, now_s)
            self.link.handle_timer(now_s)
            if self._turn is not None:
                self._turn(self, now_s)
            self.write(self.link.data_to_send())


def every(period_s: float, action: Callable[[SketchBoard], None]) -> Turn:
    """Run an action in loop() every `period_s`."""
    due_s = 0.0

    def turn(board: SketchBoard, now_s: float) -> None:
        nonlocal due_s
        if now_s >= due_s:
            due_s = now_s + period_s
            action(board)

    return turn


def publish(topic: str, payload: Callable[[SketchBoard], bytes]) -> Callable[[SketchBoard], None]:
    return lambda board: void(board.link.publish(board.ids[topic], [payload(board)]))


def void(_value: object) -> None:
    """Discard a value, so that a lambda returns None."""


def hello(_board: SketchBoard) -> bytes:
    return struct.pack("<I", 5) + b"hello"


def stamped(board: SketchBoard) -> bytes:
    """Return a sensor_msgs/Range with the board's time."""
    stamp = board.link.time(board.now_s())
    return struct.pack("<IIII", 0, stamp.secs, stamp.nsecs, 0) + bytes(1 + 4 * 4)


def announce_raw(kind: int, payload: bytes) -> bytes:
    """Return the frame of an announcement with any payload."""
    return encode_frame(kind, payload)


def overwritten_info() -> bytes:
    """The announcement of a board whose strings were overwritten by the stack."""
    return encode_frame(
        ids.PUBLISHER,
        struct.pack("<H", 101)
        + b"".join(
            struct.pack("<I", len(text)) + text
            for text in (b"temp\x00\x17\xe2ure", b"std_msgs/Float32", b"73fcbf46b49191\x01\x08\xff\x00d6a3")
        )
        + struct.pack("<i", 280),
    )


def info_bytes(info: TopicInfo) -> bytes:
    return info.encode()

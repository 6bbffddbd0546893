"""A host for a paused simulated board: it sends at the line's speed and controls the board's time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rostether.rosserial.frame import encode_frame
from rostether.rosserial.frame_decoder import FrameDecoder, Frames
from rostether.simulation.simavr.simulated_board import SimulatedBoard

STEP_MS = 20
# Events that show a fault of the program.
FAULTS = ("reset", "restart", "stack_overflow", "bad_opcode", "bad_write", "bad_read", "guarded_write")


class ScriptedHost:
    """Collects the frames that the board sends; `on_frame` is called with the id and payload of each."""

    def __init__(self, board: SimulatedBoard) -> None:
        self.board = board
        self.frames: list[tuple[int, bytes]] = []
        self.now_ms = 0
        self.on_frame: Callable[[int, bytes], None] = lambda _topic_id, _payload: None
        self._decoder = FrameDecoder()
        self._to_send = bytearray()

    @classmethod
    async def start(cls, elf: Path, *, board: str = "uno") -> ScriptedHost:
        """Start a board that is paused until `run`."""
        commands = ["watch serial"]
        simulated = await SimulatedBoard.start(
            elf, board=board, link="none", realtime=False, paused=True, commands=commands
        )
        return cls(simulated)

    def send(self, topic_id: int, payload: bytes = b"") -> None:
        """Send a frame with the next step."""
        self._to_send += encode_frame(topic_id, payload)

    def send_bytes(self, data: bytes) -> None:
        """Send any bytes with the next step."""
        self._to_send += data

    async def run(self, duration_ms: int, until: Callable[[], bool] = lambda: False) -> bool:
        """Run the board for a time; return whether a condition was met during it."""
        end_ms = self.now_ms + duration_ms
        while self.now_ms < end_ms:
            while self._to_send:
                await self.board.send(bytes(self._to_send[:256]))
                del self._to_send[:256]
            step_ms = min(STEP_MS, end_ms - self.now_ms)
            await self.board.run(f"{step_ms}ms")
            self.now_ms += step_ms
            data = bytes(self.board.serial)
            self.board.serial.clear()
            for each in self._decoder.feed(data, self.now_ms / 1000):
                if isinstance(each, Frames):
                    for payload in each.payloads:
                        self.frames.append((each.topic_id, payload))
                        self.on_frame(each.topic_id, payload)
            if until():
                return True
        return False

    def faults(self) -> list[str]:
        """Return the faults since the board was switched on."""
        names = [event.name for event in self.board.recent]
        return [name for name in names[names.index("reset") + 1 :] if name in FAULTS]

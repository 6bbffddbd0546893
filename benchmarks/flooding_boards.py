"""Boards that all flood one roscpp subscriber, over TCP, as fast as they are read: lost messages."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from benchmarks.processes import Bench, output, say, wait_until
from interop.ros1_peers import free_port

FLOOD_TYPE = "std_msgs/String"
FRAME_BYTES = 72


@dataclass(frozen=True, slots=True)
class FloodingBoards:
    """One round."""

    boards: int
    sent: int
    received: int
    seconds: float

    @property
    def lost(self) -> int:
        """Messages that did not arrive."""
        return self.sent - self.received


def flooding_boards(boards: int, messages: int) -> FloodingBoards:
    """Let boards send this number of messages together; TCP can slow all of them down."""
    port = free_port()
    each = messages // boards
    with Bench() as bench:
        bench.rostether("serve", f"tcp://:{port}")
        devices = [
            bench.module("flood_device", str(port), "send", FLOOD_TYPE, str(each)) for _ in range(boards)
        ]
        names: list[str] = []

        def announced() -> bool:
            publishers = dict(bench.master.getSystemState("/bench")[2][0])
            names[:] = publishers.get("/flood", [])
            return len(names) == boards

        wait_until(announced, f"{boards} publishers", 60.0)
        counter = bench.roscpp("count", "/flood", str(each * boards), "4")
        for name in names:
            bench.wait_for_connection(name, "/flood")
        for device in devices:
            say(device)
        words = output(counter)
        return FloodingBoards(boards, each * boards, int(words[0]), float(words[2]))


def main(arguments: list[str]) -> None:
    """Print rounds: BOARDS MESSAGES ROUNDS."""
    boards, messages, rounds = (int(word) for word in arguments)
    for _ in range(rounds):
        found = flooding_boards(boards, messages)
        rate = found.received / found.seconds
        print(f"{boards:3} boards  {found.lost:8} of {found.sent} lost  {rate:8.0f}/s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

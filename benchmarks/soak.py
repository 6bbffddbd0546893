"""A bridge on a TCP link and a pseudo-terminal that damage data and fail repeatedly; the counters must match.

python -m benchmarks.soak [MINUTES]

Each device numbers its messages. Its line to the bridge damages one in a hundred, adds garbage before one in
fifty, and is closed every few seconds. All messages that were sent undamaged after the negotiation
must be received, and no others; memory must not grow. Exits with 1 if one of these fails.
"""

from __future__ import annotations

import asyncio
import random
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from benchmarks.processes import resident_mb
from unit.bridge.line_boards import Board, line, numbered

PERIOD_S = 0.005
DAMAGED, GARBAGE = 0.01, 0.02
LINE_S = (2.0, 6.0)
PATIENCE_S = 20.0
WARM_UP_S = 20.0
MAX_GROWTH_MB = 8.0


class Count:
    """The undamaged and the damaged messages of one device; summed up at the end of each connection."""

    def __init__(self) -> None:
        self.whole: set[int] = set()
        self.damaged: set[int] = set()
        self.sent = self.reconnects = self.lost = self.strangers = 0

    def take(self, received: set[int]) -> None:
        """Compare with the received messages, and start again from zero."""
        self.sent += len(self.whole)
        self.lost += len(self.whole - received)
        self.strangers += len(self.damaged & received)
        self.whole.clear()
        self.damaged.clear()


@dataclass(frozen=True, slots=True)
class Soaked:
    """The results of both devices together; `strangers` are damaged messages that were delivered."""

    sent: int
    reconnects: int
    lost: int
    strangers: int
    grown_mb: float


async def one_line(board: Board, received: list[int], count: Count, number: int, rng: random.Random) -> int:
    """Connect, negotiate, send with faults for a few seconds, disconnect; return the next number."""
    await board.connect(rng.randbytes(rng.randrange(2000)))
    await board.settle(received, number)
    number += 1
    end_s = time.monotonic() + rng.uniform(*LINE_S)
    while time.monotonic() < end_s:
        frame = bytearray(numbered(number))
        if rng.random() < DAMAGED:
            frame[rng.randrange(len(frame))] ^= 1 << rng.randrange(8)
            count.damaged.add(number)
        else:
            count.whole.add(number)
        garbage = rng.randbytes(rng.randrange(40)) if rng.random() < GARBAGE else b""
        await board.send(garbage + bytes(frame))
        number += 1
        await asyncio.sleep(PERIOD_S)
    # Lost messages never arrive; on a busy machine, the others may arrive late.
    last_s = time.monotonic() + PATIENCE_S
    while not count.whole.issubset(received) and time.monotonic() < last_s:
        await asyncio.sleep(0.05)
    await asyncio.sleep(0.5)
    await board.hang_up()
    count.reconnects += 1
    return number


async def one_device(kind: str, folder: Path, end_s: float, count: Count, rng: random.Random) -> None:
    """Serve one link with its device until `end_s`."""
    async with line(kind, folder) as (bridge, board):
        received = await bridge.listen("/count")
        number = 1
        while time.monotonic() < end_s:
            number = await one_line(board, received, count, number, rng)
            bridge.reporter.lines.clear()
            bridge.network.logs.clear()
            count.take(set(received))
            received.clear()


async def soak(seconds: float, *, warm_up_s: float = WARM_UP_S) -> Soaked:
    """Run both devices; memory is compared with that after the warm-up."""
    began_s = time.monotonic()
    counts = {kind: Count() for kind in ("tcp", "pty")}
    with tempfile.TemporaryDirectory() as folder:
        devices = asyncio.gather(
            *(
                one_device(kind, Path(folder), began_s + seconds, count, random.Random(kind))
                for kind, count in counts.items()
            )
        )
        await asyncio.sleep(min(warm_up_s, seconds))
        warm_mb = resident_mb("self")
        await devices
    return Soaked(
        sum(count.sent for count in counts.values()),
        sum(count.reconnects for count in counts.values()),
        sum(count.lost for count in counts.values()),
        sum(count.strangers for count in counts.values()),
        resident_mb("self") - warm_mb,
    )


def main(minutes: float) -> int:
    """Run the test, print the results, return the exit code."""
    soaked = asyncio.run(soak(60 * minutes))
    print(
        f"{soaked.sent:,} messages, {soaked.reconnects} reconnects: {soaked.lost} whole ones lost, "
        f"{soaked.strangers} damaged ones delivered, memory grew by {soaked.grown_mb:.1f} MB"
    )
    return 1 if soaked.lost or soaked.strangers or soaked.grown_mb > MAX_GROWTH_MB else 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0))

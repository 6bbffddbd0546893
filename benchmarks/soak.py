"""A bridge on TCP links that lose, damage and end all the time; at the end the counters must be equal.

python -m benchmarks.soak [MINUTES]

Each device numbers its messages. The line to the bridge damages one chunk in a hundred, puts garbage before
one in fifty, and hangs up every few seconds. What the device wrote whole on a line that the bridge had
settled on must be heard, nothing else may be, and memory must not grow. Exits with 1 if that does not hold.
"""

from __future__ import annotations

import asyncio
import random
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from benchmarks.processes import resident_mb
from unit.bridge.tcp_boards import Bridge, TcpBoard, numbered

PERIOD_S = 0.005
DAMAGED, GARBAGE = 0.01, 0.02
LINE_S = (2.0, 6.0)
WARM_UP_S = 20.0
MAX_GROWTH_MB = 8.0


class Count:
    """What was sent whole, and what was damaged."""

    def __init__(self) -> None:
        self.whole: set[int] = set()
        self.damaged: set[int] = set()
        self.reconnects = 0


async def one_line(board: TcpBoard, heard: list[int], count: Count, number: int, rng: random.Random) -> int:
    """Connect, settle, send with faults for some seconds, hang up; returns the next number."""
    await board.connect(rng.randbytes(rng.randrange(2000)))
    await board.settle(heard, number)
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
    await asyncio.sleep(0.5)
    await board.hang_up()
    count.reconnects += 1
    return number


async def soak(minutes: float) -> bool:
    """Run; returns whether all held."""
    rng = random.Random(1)
    count = Count()
    end_s = time.monotonic() + 60 * minutes
    warm_s = min(time.monotonic() + WARM_UP_S, end_s)
    warm_mb = 0.0
    async with Bridge() as bridge:
        heard = await bridge.listen("/count")
        board = TcpBoard(bridge.port)
        number = 1
        lost = strangers = 0
        while time.monotonic() < end_s:
            number = await one_line(board, heard, count, number, rng)
            bridge.reporter.lines.clear()
            bridge.network.logs.clear()
            lost += len(count.whole - set(heard))
            strangers += len(count.damaged & set(heard))
            heard.clear()
            count.whole.clear()
            count.damaged.clear()
            if not warm_mb and time.monotonic() >= warm_s:
                warm_mb = resident_mb("self")
    grown_mb = resident_mb("self") - (warm_mb or resident_mb("self"))
    print(
        f"{number:,} messages, {count.reconnects} reconnects: {lost} whole ones lost, "
        f"{strangers} damaged ones delivered, memory grew by {grown_mb:.1f} MB"
    )
    return not lost and not strangers and grown_mb <= MAX_GROWTH_MB


if __name__ == "__main__":
    sys.exit(0 if asyncio.run(soak(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0)) else 1)

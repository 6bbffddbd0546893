"""The delays of commands and of a stop to twenty robots on bad Wi-Fi (30 % lost, 100 ms late).

python -m benchmarks.fleet
"""

from __future__ import annotations

import asyncio
import itertools
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from interop.fleet_robots import KEY, ZERO_COMMAND, fleet_on_bad_wifi
from programs import started
from rostether.platform.command_frame import Flags, decode_frame
from waiting import until

_SECONDS = 15.0


async def measure(folder: Path) -> str:
    """Return the gaps between accepted commands, and when the last robot obeyed a stop."""
    async with fleet_on_bad_wifi(folder) as (robots, network, _, options):
        async with started("fleet", "drive", "--all", *options):
            await until(lambda: all(robot.commands for robot in robots))
            await asyncio.sleep(_SECONDS)
            gaps_s = sorted(
                later - earlier
                for robot in robots
                for (_, earlier), (_, later) in itertools.pairwise(robot.commands)
            )
            async with started("fleet", "stop", *options) as stopper:
                await stopper.process.wait()
        sent_s = next(at_s for frame, at_s in network.sent if Flags.STOP in decode_frame(frame, KEY).flags)
        stopped_s = [
            next(at_s for payload, at_s in robot.commands if payload == ZERO_COMMAND and at_s >= sent_s)
            for robot in robots
        ]
    return (
        f"gap between commands: p99 {1000 * gaps_s[len(gaps_s) * 99 // 100]:.0f} ms (wanted: below 250 ms), "
        f"longest {1000 * gaps_s[-1]:.0f} ms; stop: {1000 * (max(stopped_s) - sent_s):.0f} ms "
        "until the last robot (wanted: 200 ms)"
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        print(asyncio.run(measure(Path(name))))

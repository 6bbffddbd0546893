"""Records a flood of 64-byte messages: what is lost and what it costs, beside Debian's rosbag.

python -m benchmarks.recording [SECONDS] [MESSAGES_PER_SECOND]
"""

from __future__ import annotations

import asyncio
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from rostether.graph.ports import Publisher
from rostether.joining import join
from rostether.msgdef.registry import Registry
from rostether.recording.bag_reader import BagReader
from rostether.ros1.master.server import MasterServer

PAYLOAD = (60).to_bytes(4, "little") + b"x" * 60
PERIOD_S = 0.005


async def flood(publisher: Publisher, seconds: float, rate: float) -> int:
    """Publish at a rate; returns how many messages."""
    loop = asyncio.get_running_loop()
    began_s = loop.time()
    sent = 0
    while (passed_s := loop.time() - began_s) < seconds:
        due = int(passed_s * rate) - sent
        if due and not publisher.publish_raw([PAYLOAD] * due):
            await publisher.drained(1.0)
        sent += due
        await asyncio.sleep(PERIOD_S)
    return sent


async def measure(name: str, command: list[str], file: Path, seconds: float, rate: float) -> None:
    """Let a recorder record the flood, and print what it did."""
    master = await MasterServer.start(port=0)
    environ = {"ROS_MASTER_URI": master.uri}
    process = subprocess.Popen(
        [*command, "-O", str(file), "/flood"],
        env={**os.environ, **environ, "ROS_HOSTNAME": "localhost", "HOME": str(file.parent)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    async with join("flood", environ=environ) as graph:
        publisher = await graph.raw.advertise("/flood", Registry().message_type("std_msgs/String"))
        while not publisher.subscriber_count:
            await asyncio.sleep(0.01)
        await asyncio.sleep(1.0)
        before_s = cpu_s(process.pid)
        sent = await flood(publisher, seconds, rate)
        await publisher.drained(5.0)
        await asyncio.sleep(1.0)
        used_s = cpu_s(process.pid) - before_s
        process.send_signal(signal.SIGINT)
        await asyncio.to_thread(process.wait)
        dropped = publisher.dropped_count
    await master.close()
    reader = BagReader(file)
    kept = sum(reader.counts.values())
    reader.close()
    print(
        f"{name:<16} {sent / seconds:>9.0f}/s sent, {sent - kept} of {sent} lost ({dropped} by us), "
        f"{used_s / seconds:.2f} cores",
        flush=True,
    )


def cpu_s(pid: int) -> float:
    """Return the processor time a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def main(arguments: list[str]) -> None:
    """Measure ours, and Debian's where it is installed."""
    seconds = float(arguments[0]) if arguments else 10.0
    rate = float(arguments[1]) if len(arguments) > 1 else 100_000.0
    with tempfile.TemporaryDirectory() as folder:
        ours = [sys.executable, "-m", "rostether", "bag", "record"]
        await measure("rostether", ours, Path(folder) / "ours.bag", seconds, rate)
        await measure("rostether --lz4", [*ours, "--lz4"], Path(folder) / "lz4.bag", seconds, rate)
        theirs = Path("/usr/lib/rosbag/record")
        if theirs.exists() or shutil.which("rosbag", path="/usr/bin"):
            command = [str(theirs)] if theirs.exists() else ["/usr/bin/rosbag", "record"]
            await measure("Debian's rosbag", command, Path(folder) / "theirs.bag", seconds, rate)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1:]))

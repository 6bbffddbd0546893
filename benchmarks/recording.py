"""Records and plays a flood of 64-byte messages: losses and cost, compared with Debian's rosbag.

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
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from rostether.graph.ports import Publisher
from rostether.joining import join
from rostether.msgdef.registry import Registry
from rostether.recording.bag.writer import BagWriter
from rostether.recording.files import open_recording
from rostether.recording.recorded import Connection
from rostether.ros1.master.server import MasterServer

PAYLOAD = (60).to_bytes(4, "little") + b"x" * 60
PERIOD_S = 0.005
PLAYED = 300_000


@dataclass(frozen=True, slots=True)
class Recorded:
    """One recording of the flood."""

    name: str
    sent_hz: float
    sent: int
    lost: int
    cores: float


@dataclass(frozen=True, slots=True)
class Played:
    """One playback at full speed."""

    name: str
    rate_hz: float
    lost: int
    cores: float


async def flood(publisher: Publisher, seconds: float, rate: float) -> int:
    """Publish at a rate; return the number of published messages."""
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


async def record(name: str, command: list[str], file: Path, seconds: float, rate: float) -> Recorded:
    """Let a recorder record the flood."""
    master = await MasterServer.start(port=0)
    environ = {"ROS_MASTER_URI": master.uri}
    process = _started([*command, "-O", str(file), "/flood"], environ, file.parent)
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
    await master.close()
    with closing(open_recording(file)) as reader:
        kept = sum(reader.counts.values())
    return Recorded(name, sent / seconds, sent, sent - kept, used_s / seconds)


async def play(name: str, command: list[str], file: Path) -> Played:
    """Let a player play the flood without waiting, to our subscriber."""
    master = await MasterServer.start(port=0)
    environ = {"ROS_MASTER_URI": master.uri}
    loop = asyncio.get_running_loop()
    count, first_s, last_s = 0, 0.0, 0.0

    def take(payloads: Sequence[bytes]) -> None:
        nonlocal count, first_s, last_s
        last_s = loop.time()
        first_s = first_s or last_s
        count += len(payloads)

    async with join("listener", environ=environ) as graph:
        await graph.raw.subscribe("/flood", Registry().message_type("std_msgs/String"), take)
        process = _started([*command, str(file)], environ, file.parent)
        used_s = 0.0
        while process.poll() is None:
            used_s = cpu_s(process.pid) or used_s
            await asyncio.sleep(0.05)
        await asyncio.sleep(0.5)
    await master.close()
    span_s = max(last_s - first_s, 1e-3)
    return Played(name, count / span_s, PLAYED - count, used_s / span_s)


def write_flood(file: Path) -> None:
    """Write the recording that is played."""
    writer = BagWriter(file)
    number = writer.add_connection(Connection("/flood", Registry().message_type("std_msgs/String"), "/flood"))
    for index in range(0, PLAYED, 100):
        writer.write(number, 1_700_000_000_000_000_000 + index * 10_000, [PAYLOAD] * 100)
    writer.close()


def _started(command: list[str], environ: dict[str, str], folder: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command,
        env={**os.environ, **environ, "ROS_HOSTNAME": "localhost", "HOME": str(folder)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def cpu_s(pid: int) -> float:
    """Return the processor time a process has used; 0 when it has ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def recordings(seconds: float = 10.0, rate: float = 100_000.0) -> list[Recorded]:
    """Measure our recorder in each format, and Debian's if it is installed."""
    rostether = [sys.executable, "-m", "rostether", "bag", "record"]
    runs = [
        ("rostether, .bag", rostether, "rostether.bag"),
        ("rostether, .mcap", rostether, "rostether.mcap"),
        ("rostether, .bag, LZ4", [*rostether, "--lz4"], "lz4.bag"),
    ]
    if debian := _debians("record"):
        runs.append(("Debian's rosbag, .bag", debian, "debian.bag"))
    with tempfile.TemporaryDirectory() as folder:
        return [
            asyncio.run(record(name, command, Path(folder) / file, seconds, rate))
            for name, command, file in runs
        ]


def playbacks() -> list[Played]:
    """Measure our player, and Debian's if it is installed."""
    rostether = [sys.executable, "-m", "rostether", "bag", "play", "--immediate", "--wait-for-subscribers"]
    runs = [("rostether", rostether)]
    if debian := _debians("play"):
        # Its queue is limited by the number of messages, and drops the others.
        runs.append(
            ("Debian's rosbag", [*debian, "--immediate", "--wait-for-subscribers", f"--queue={PLAYED}"])
        )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "flood.bag"
        write_flood(file)
        return [asyncio.run(play(name, command, file)) for name, command in runs]


def _debians(verb: str) -> list[str]:
    program = Path("/usr/lib/rosbag") / verb
    if program.exists():
        return [str(program)]
    return ["/usr/bin/rosbag", verb] if shutil.which("rosbag", path="/usr/bin") else []


def main(arguments: list[str]) -> None:
    """Print the measurements."""
    seconds = float(arguments[0]) if arguments else 10.0
    rate = float(arguments[1]) if len(arguments) > 1 else 100_000.0
    for kept in recordings(seconds, rate):
        lost = f"{kept.lost} of {kept.sent} lost"
        print(f"{kept.name:<22} {kept.sent_hz:>9,.0f}/s, {lost}, {kept.cores:.2f} cores")
    for each in playbacks():
        print(f"{each.name:<22} {each.rate_hz:>9,.0f}/s played, {each.lost} lost, {each.cores:.2f} cores")


if __name__ == "__main__":
    main(sys.argv[1:])

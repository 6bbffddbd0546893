"""`serve --record DIR`: bags of all topics; the bridge continues when they cannot be written."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from pathlib import Path

from programs import started
from rostether.cli.bag.bridge_recording import BagRecording, bags_recorded
from rostether.errors import RecordingError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.recording.bag.reader import BagReader
from rostether.recording.files import open_recording
from rostether.ros2.types.type_support import Ros2Types
from unit.cli.command_shell import Shell
from unit.cli.link.test_group import board_at, master, receive
from unit.recording.bags import STRING, text
from waiting import until


class _Lines:
    def __init__(self) -> None:
        self.lines: list[tuple[Level, str]] = []

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        self.lines.append((level, text))

    async def wait_for(self, part: str) -> Level:
        async with asyncio.timeout(60):
            while True:
                for level, line in self.lines:
                    if part in line:
                        return level
                await asyncio.sleep(0.005)


def recorded(folder: Path) -> list[bytes]:
    """Return the messages on /chatter in the only bag of a folder; none before the bag exists."""
    try:
        (path,) = folder.iterdir()
        return [each.payload for each in BagReader(path).messages() if each.connection.topic == "/chatter"]
    except (OSError, ValueError, RecordingError):
        return []


async def test_serve_records_the_messages_of_its_boards(tmp_path: Path) -> None:
    bags = tmp_path / "bags"
    async with (
        board_at(tmp_path / "arm"),
        master() as environ,
        started("serve", f"{tmp_path}/arm", "--record", str(bags), **environ) as serve,
    ):
        # The recorder writes a few times per second.
        await until(lambda: len(recorded(bags)) >= 5, "messages in the bag")
        await serve.stop(signal.SIGINT)
        assert f", in {bags}" in serve.text
    (path,) = bags.iterdir()
    assert path.suffix == ".bag"
    assert not BagReader(path).damage
    assert len(recorded(bags)) >= 5
    assert set(recorded(bags)) == {text("hello")}


async def test_full_bags_are_followed_by_others_and_the_oldest_go(tmp_path: Path) -> None:
    network = MemoryNetwork()
    node = await network.join("/node")
    publisher = await node.advertise("/chat", STRING)
    reporter = _Lines()
    async with bags_recorded(BagRecording(tmp_path, 0.1, 2), network.join, reporter):
        await reporter.wait_for("Subscribing to /chat")
        async with asyncio.timeout(60):
            while not any("_3.bag" in line for _, line in reporter.lines):
                publisher.publish_raw([text("x" * 1000)] * 10)
                await asyncio.sleep(0)
    assert sorted(path.name[-6:] for path in tmp_path.iterdir()) == ["_2.bag", "_3.bag"]
    assert all(path.stat().st_size < 200_000 for path in tmp_path.iterdir())
    await node.close()


async def test_a_folder_that_cannot_be_written_stops_only_the_recording(tmp_path: Path) -> None:
    reporter = _Lines()
    async with bags_recorded(BagRecording(tmp_path / "gone", 1, None), MemoryNetwork().join, reporter):
        assert await reporter.wait_for("; boards stay connected") is Level.ERROR
    assert reporter.lines[0][1].startswith(f"cannot write {tmp_path / 'gone'}")


def test_a_file_is_not_a_folder_for_bags(tmp_path: Path, shell: Shell) -> None:
    line = shell.failure("serve", "tcp://:0", "--record", str(tmp_path / "problem.jsonl"))
    assert "--record-line FILE records the bytes on the boards' lines" in line


async def test_on_ros2_alone_a_ros2_bag(tmp_path: Path) -> None:
    network = MemoryNetwork()
    node = await network.join("/node")
    publisher = await node.advertise("/chat", STRING)
    types = Ros2Types(Registry(), Ros2Definitions())
    reporter = _Lines()
    async with bags_recorded(BagRecording(tmp_path, 0.1, 2), network.join, reporter, types=types):
        await reporter.wait_for("Subscribing to /chat")
        async with asyncio.timeout(60):
            while not any("_3.mcap" in line for _, line in reporter.lines):
                publisher.publish_raw([text("x" * 1000)] * 10)
                await asyncio.sleep(0)
    (folder,) = tmp_path.iterdir()
    assert sorted(path.name[-7:] for path in folder.iterdir()) == ["_2.mcap", "_3.mcap", "ta.yaml"]
    reader = open_recording(folder)
    (connection,) = reader.counts
    assert connection.shown_type == "std_msgs/msg/String"
    assert not reader.damage
    assert {each.payload for each in reader.messages()} == {text("x" * 1000)}
    reader.close()
    await node.close()


async def test_a_full_disk_stops_the_recording_and_not_the_bridge(tmp_path: Path) -> None:
    async with board_at(tmp_path / "arm", 0.002), master() as environ:
        # A limit for the size of files has the effect of a full disk.
        words = (
            f"ulimit -f 20; exec {sys.executable} -m rostether serve {tmp_path}/arm --record {tmp_path}/bags"
        )
        clean = {name: value for name, value in os.environ.items() if not name.startswith("ROS")}
        process = await asyncio.create_subprocess_exec(
            *("bash", "-c", words),
            env=clean | environ | {"PYTHONUNBUFFERED": "1"},
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
        )
        try:
            assert process.stdout is not None
            async with asyncio.timeout(100):
                while b"boards stay connected" not in (line := await process.stdout.readline()):
                    assert line, "it ended"
            assert b"File too large; choose a disk that accepts larger files; recording stopped" in line
            await receive(environ, "/chatter", 10)
            process.send_signal(signal.SIGINT)
            out, _ = await process.communicate()
            assert b"Traceback" not in out
        finally:
            if process.returncode is None:
                process.kill()
                await process.communicate()
    (path,) = (tmp_path / "bags").iterdir()
    assert BagReader(path).span_ns is not None

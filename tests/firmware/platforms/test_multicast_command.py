"""ros/multicast_command.h on the host: it obeys and answers like the receiver in Python, and reopens its
socket.
"""

from __future__ import annotations

import asyncio
import contextlib
import random
import struct
import subprocess
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from firmware.platforms.programs import EXTRAS, compile_program
from rostether.platform.command_channel import CommandChannel
from rostether.platform.command_frame import CommandFrame, Flags
from rostether.platform.command_link import (
    REPEAT_S,
    CommandReceiver,
    CommandSender,
    ReceiverSettings,
    SenderSettings,
)
from rostether.platform.multicast_socket import open_sender
from rostether.platform.status_frame import Refusal, RobotStatus, decode_status
from rostether.platform.status_reporter import StatusReporter
from unit.platform.datagrams import loopback_group

pytestmark = pytest.mark.gcc

ON_HOST = EXTRAS / "arduino_on_host"
SANITIZED = ("g++", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DARDUINO=10819")
KEY = b"0123456789abcdef"
KIND = bytes.fromhex("7528cb4c")
ROBOT = ReceiverSettings(3, groups=0b10, kind=KIND, key=KEY)
ADDRESS = "10.0.0.1:5000"
TIMEOUT_S = 60.0


@pytest.fixture(scope="session")
def robot(control_library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("robot") / "robot"
    command = [*SANITIZED, f"-I{ON_HOST}"]
    return compile_program(command, [ON_HOST / "multicast_robot.cpp"], control_library, output)


def python_lines(series: list[tuple[int, bytes]]) -> list[str]:
    """Return the receiver's commands and answers for the same datagrams."""
    robot, reporter, lines = CommandReceiver(ROBOT), StatusReporter(3, KEY), []
    for now_ms, datagram in series:
        now_s = now_ms / 1000
        if robot.expire(now_s):
            lines.append("3 -")
        frame = robot.receive(datagram, now_s)
        status = reporter.answer(robot, ADDRESS, now_s, lambda: -61)
        action = 0 if frame is None else 1 if robot.is_moving else 2
        lines.append(f"{action} {status.hex() if status else '-'}")
    return lines


def sketch_lines(robot: Path, series: list[tuple[int, bytes]]) -> list[str]:
    text = "".join(f"{now_ms} {datagram.hex()}\n" for now_ms, datagram in series)
    completed = subprocess.run([robot], input=text, capture_output=True, text=True, timeout=120, check=True)
    return completed.stdout.splitlines()


def status_of(line: str) -> RobotStatus:
    return decode_status(bytes.fromhex(line[2:]), KEY)


def test_it_obeys_and_answers_like_the_python_receiver(robot: Path) -> None:
    rng = random.Random(16)
    to_robot = SenderSettings(3, to_groups=False, kind=KIND, key=KEY)
    first = CommandSender(to_robot, 1_700_000_000_000_000)
    second = CommandSender(replace(to_robot, target=2, to_groups=True), 1_700_000_000_000_001)
    recorded: list[bytes] = []
    series: list[tuple[int, bytes]] = []
    now_ms = 40_000
    for round_number in range(400):
        # Two senders whose times to live do not overlap; a board keeps no counts of other senders.
        sender = second if round_number > 250 else first
        payload = struct.pack("<dd", rng.randrange(-180, 180), rng.random())
        sent = rng.choice(
            [
                sender.command(payload, 0.0),
                sender.command(payload, 0.0)[:1],
                [sender.release()] if round_number % 40 == 39 else sender.repeat(1.0),
                sender.halt(1.0),
                [rng.choice(recorded)] if recorded else [],
                [CommandFrame(3, 5, 1, kind=KIND, payload=payload).encode(bytes(16))],
                [CommandFrame(2, 9, 1, kind=KIND, payload=payload).encode(KEY)],
            ]
        )
        for datagram in sent:
            recorded.append(datagram)
            damaged = bytearray(datagram)
            damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
            series += [
                (now_ms, bytes(damaged)),
                (now_ms, datagram[: rng.randrange(len(datagram))] or b"\0"),
            ]
            series.append((now_ms, datagram))
        now_ms += rng.choice([17, 57, 261, 1100]) if round_number != 250 else 5000
    answers = python_lines(series)
    assert {each.split()[0] for each in answers} == {"0", "1", "2", "3"}
    obeyed = sketch_lines(robot, series)
    assert [each.split()[0] for each in obeyed] == [each.split()[0] for each in answers]
    # A board answers a stop earlier after a command.
    both = [
        pair for pair in zip(obeyed, answers, strict=True) if not any(each.endswith("-") for each in pair)
    ]
    assert len(both) > 50
    # The receiver sends the address of the sender as text, the board as bytes.
    assert [status_of(each) for each, _ in both] == [status_of(each) for _, each in both]


def test_tags_of_every_length(robot: Path) -> None:
    series = [
        (5, CommandFrame(3, 7, 1 + size, kind=KIND, payload=bytes(range(size))).encode(KEY))
        for size in range(32)
    ]
    assert {each[0] for each in sketch_lines(robot, series)} == {"1"}


def test_other_senders_are_refused_with_the_name_of_the_holder(robot: Path) -> None:
    to_robot = SenderSettings(3, to_groups=False, kind=KIND, key=KEY)
    first, second = CommandSender(to_robot, 1_000), CommandSender(to_robot, 2_000)
    other_type = CommandSender(replace(to_robot, kind=b"\1\2\3\4"), 3_000)
    untyped = CommandSender(replace(to_robot, kind=bytes(4)), 4_000)
    held = second.command(b"x", 0.0)[0]
    series = [
        (10_000, first.command(b"x", 0.0)[0]),
        (10_010, held),
        (10_280, first.repeat(1.0)[0]),
        (10_590, held),
        (10_600, second.repeat(1.0)[0]),
        (10_700, first.repeat(1.0)[0]),
        (11_200, second.release()),
        (12_100, first.query()),
        (13_200, other_type.command(b"x", 0.0)[0]),
        (14_500, other_type.stop(1.0)[0]),
        (15_900, untyped.release()),
        # A frame that releases the robot must not move it, because no sender would stop it.
        (17_000, CommandFrame(3, 5_000, 1, Flags.ARMED | Flags.RELEASE, kind=KIND).encode(KEY)),
    ]
    lines = sketch_lines(robot, series)
    assert [each[0] for each in lines] == [each[0] for each in python_lines(series)]
    assert lines[-1][0] == "2"
    statuses = [status_of(each) for each in lines if each[2:] != "-"]
    assert [(each.epoch_us, each.refusal, each.holder, each.is_moving) for each in statuses] == [
        (1_000, Refusal.NONE, ADDRESS, True),
        (2_000, Refusal.HELD, ADDRESS, True),
        (2_000, Refusal.NONE, ADDRESS, True),
        (1_000, Refusal.OLDER, ADDRESS, True),
        (2_000, Refusal.NONE, "", False),
        (1_000, Refusal.NONE, "", False),
        (3_000, Refusal.OTHER_TYPE, "", False),
        (3_000, Refusal.NONE, ADDRESS, False),
        (4_000, Refusal.NONE, "", False),
        (5_000, Refusal.NONE, "", False),
    ]
    assert all(each.signal_dbm == -61 and each.robot_id == 3 for each in statuses)


class Robot:
    """The running sketch, with its output lines."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._output = process.stdout
        self.lines: list[str] = []

    async def wait_for_line(self, expected: str) -> None:
        """Wait for a new line with this text."""
        async with asyncio.timeout(TIMEOUT_S):
            while True:
                assert self._output is not None
                line = (await self._output.readline()).decode().strip()
                assert line, f"the sketch has ended without {expected!r}: {self.lines[-5:]}"
                self.lines.append(line)
                if line == expected:
                    return


@contextlib.asynccontextmanager
async def running(program: Path, *arguments: object) -> AsyncIterator[Robot]:
    process = await asyncio.create_subprocess_exec(
        program, *map(str, arguments), stdout=asyncio.subprocess.PIPE
    )
    try:
        yield Robot(process)
    finally:
        process.kill()
        await process.communicate()


@contextlib.asynccontextmanager
async def sending(channel: CommandChannel, payload: bytes) -> AsyncIterator[None]:
    sender = CommandSender(
        SenderSettings(3, to_groups=False, kind=KIND, key=KEY), int(asyncio.get_running_loop().time() * 1e6)
    )
    channel.epoch_us = sender.epoch_us

    async def repeat() -> None:
        while True:
            # The first datagram is too long for the sketch; the others must arrive.
            for datagram in (bytes(1000), *sender.command(payload, asyncio.get_running_loop().time())):
                channel.send(datagram)
            await asyncio.sleep(REPEAT_S)

    task = asyncio.create_task(repeat())
    try:
        yield
    finally:
        task.cancel()


async def test_a_sketch_obeys_answers_and_stops_when_its_sender_is_silent(robot: Path) -> None:
    group = loopback_group()
    channel = CommandChannel(group, lambda level, text: None, key=KEY)
    async with running(robot, group.port) as sketch:
        await sketch.wait_for_line("open")
        assert sketch.lines == ["halt", "open"]
        async with sending(channel, struct.pack("<dd", -45, 0.5)):
            await sketch.wait_for_line("drive -45 0.5")
            async with asyncio.timeout(TIMEOUT_S):
                while not channel.table.robots:
                    await asyncio.sleep(0.01)
            (known,) = channel.table.robots.values()
            assert (known.status.robot_id, known.status.is_moving, known.address[1]) == (3, True, group.port)
            assert known.status.holder.rpartition(":")[0] == known.address[0]
        # The sender has ended without a stop. The silence also reopens the socket.
        await sketch.wait_for_line("halt")
        await sketch.wait_for_line("open")
    channel.close()


async def test_a_stalled_socket_is_reopened_and_receives_again(robot: Path) -> None:
    group = loopback_group()
    channel = CommandChannel(group, lambda level, text: None, key=KEY)
    async with running(robot, group.port, 10) as sketch:
        await sketch.wait_for_line("open")
        async with sending(channel, struct.pack("<dd", 90, 1)):
            for _ in range(3):
                await sketch.wait_for_line("drive 90 1")
                await sketch.wait_for_line("open")
    channel.close()


async def test_bare_datagrams_are_obeyed_until_they_end(robot: Path) -> None:
    group = loopback_group()
    # The bytes of the reference's bridge; other data moves nothing.
    message = bytes.fromhex("0000000000000080000000000000f03f")
    datagrams = (b"", bytes(15), bytes(17), bytes(100), message)

    async def repeat() -> None:
        with open_sender(group, "127.0.0.1") as sock:
            while True:
                for datagram in datagrams:
                    sock.sendto(datagram, (group.group, group.port))
                await asyncio.sleep(0.02)

    async with running(robot, group.port, "bare") as sketch:
        sending_all = asyncio.create_task(repeat())
        await sketch.wait_for_line("drive -0 1")
        sending_all.cancel()
        await sketch.wait_for_line("halt")
        await sketch.wait_for_line("open")
    assert set(sketch.lines) == {"halt", "open", "drive -0 1"}


def test_flags_are_those_of_the_frame() -> None:
    text = (EXTRAS.parents[1] / "src" / "ros" / "command_receiver.h").read_text()
    names = {
        "ARMED": "ARMED",
        "STOP": "STOP_ALL",
        "RELEASE": "RELEASE",
        "TO_GROUPS": "TO_GROUPS",
        "QUERY": "QUERY",
    }
    # Boards forward nothing.
    flags = [each for each in Flags if each is not Flags.FORWARD]
    written = ", ".join(f"{names[each.name or '']} = {each.value}" for each in flags)
    assert f"enum Flags {{ {written} }}" in text

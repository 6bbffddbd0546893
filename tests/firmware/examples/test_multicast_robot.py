"""The robot of a fleet on a simulated Ethernet shield: it obeys commands and stops."""

from __future__ import annotations

import asyncio
import contextlib
import re
import struct
import time
from collections.abc import AsyncIterator
from pathlib import Path

from firmware.examples.established import has_measured_compiler
from firmware.examples.stage import EXAMPLES, TIMEOUT_S, build_example
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.platform.command_channel import CommandChannel
from rostether.platform.command_link import REPEAT_S, CommandSender, SenderSettings
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.siphash import siphash_2_4
from rostether.simulation.simavr.board_events import BoardEvent
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from unit.firmware.sketches import write_sketch
from unit.platform.datagrams import GROUP

CLOCK_HZ = 16_000_000
TEXT = (EXAMPLES / "MulticastRobot/MulticastRobot.ino").read_text()
KEY = bytes.fromhex(re.findall(r'KEY "(\w+)"', TEXT)[0])
TTL_S = 0.3
# The time that the robot needs for frames that have arrived.
GRACE_S = 0.1
# The flash and RAM in bytes that the library adds to a sketch that receives and decodes bare commands, on an
# Uno: with avr-gcc 5.4, and with newer versions (1,816 bytes of flash with version 16).
MAX_FLASH, MAX_RAM = (1500, 120)
MAX_FLASH_NEWER, MAX_RAM_NEWER = (1900, 180)
BARE_COMMANDS = """
class BareCommands {
 public:
  void setRobot(int) {}
  void begin(IPAddress group, uint16_t port) { udp.beginMulticast(group, port); }
  bool isMoving() { return false; }
  void spinOnce() {
    byte bytes[100];
    arduino_control::ArduinoControl command;
    const int size = udp.parsePacket();
    if (size <= 0 || udp.read(bytes, sizeof bytes) != size) return;
    if (command.deserialize(bytes, size) > 0) drive(command);
  }
  EthernetUDP udp;
} commands;
"""

TAG_LENGTHS = 17
# Makes each tag, and checks that a frame has it.
TAGS = f"""
#include <ros/siphash.h>
const ros::FleetKey key ROS_FLASH("{KEY.hex()}");
uint8_t bytes[{TAG_LENGTHS} + 8];
__attribute__((used)) volatile uint8_t tags[8 * {TAG_LENGTHS}];
__attribute__((used)) volatile uint8_t checked;
void setup() {{
  for (uint8_t length = 0; length < {TAG_LENGTHS}; ++length) {{
    for (uint8_t i = 0; i < length; ++i) bytes[i] = i;
    for (uint8_t i = length; i < length + 8; ++i) bytes[i] = 0;
    ros::SipHash::combine(&key, bytes, length);
    for (uint8_t i = 0; i < 8; ++i) tags[8 * length + i] = bytes[length + i];
    if (ros::SipHash::combine(&key, bytes, length) == 0) ++checked;
  }}
}}
void loop() {{}}
"""


def _left_duty(event: BoardEvent) -> float | None:
    """Return the left motor's duty in an event; at rest and at full speed, no timer drives the pin."""
    found = event.values.get("duty" if event.name == "pwm" else "level")
    return None if event.values.get("pin") != "D3" or found is None else float(found)


class Fleet:
    """The robot, and one sender that repeats its command."""

    def __init__(self, board: SimulatedBoard, channel: CommandChannel) -> None:
        self.board = board
        self.channel = channel
        settings = SenderSettings(1, to_groups=False, kind=bytes.fromhex("7528cb4c"), key=KEY)
        self._sender = CommandSender(settings, time.time_ns() // 1000)
        channel.epoch_us = self._sender.epoch_us

    @contextlib.asynccontextmanager
    async def driving(
        self, direction: float, speed: float, period_s: float = REPEAT_S
    ) -> AsyncIterator[None]:
        """Send a command until the block ends, then nothing, not even a stop."""

        async def repeat() -> None:
            while True:
                for datagram in self._sender.command(struct.pack("<dd", direction, speed), time.monotonic()):
                    self.channel.send(datagram)
                await asyncio.sleep(period_s)

        task = asyncio.create_task(repeat())
        try:
            yield
        finally:
            task.cancel()

    async def wheels(self) -> tuple[int, int]:
        """Return the duty of the left and the right motor, from -255 to 255."""
        event = await self.board.ask("wheels", "wheels")
        return round(event["left"] * 255), round(event["right"] * 255)

    def stalled_s(self) -> float:
        """Return the board's time when the chip first stopped receiving."""
        return next(
            each.time_s for each in self.board.recent if each.name == "w5100" and each["state"] == "stalled"
        )

    async def wait_for_wheels(self, left: int, right: int) -> None:
        """Wait until both motors have these duties."""
        async with asyncio.timeout(TIMEOUT_S):
            while await self.wheels() != (left, right):
                await asyncio.sleep(0.005)

    async def time_s(self) -> float:
        """Return the board's time, in seconds."""
        return await self.board.cycles() / CLOCK_HZ

    def duty_changed_s(self, duty: int) -> float:
        """Return the board's time, in seconds, when the left motor last got this duty."""
        times_s = [each.time_s for each in self.board.recent if _left_duty(each) == duty]
        return times_s[-1] if times_s else 0.0


@contextlib.asynccontextmanager
async def running(name: str, kind: str, *commands: str) -> AsyncIterator[Fleet]:
    """Run the example, with its key and in a group that only this test uses."""
    built = await build_example(name, kind)
    commands = ("watch D3", *commands)
    async with await SimulatedBoard.start(built.elf, board=kind, link="none", commands=commands) as board:
        group = GroupAddress(GROUP, 11412, ("lo",), ttl=0)
        channel = CommandChannel(group, lambda level, text: None, key=KEY)
        try:
            yield Fleet(board, channel)
        finally:
            channel.close()


async def test_it_obeys_commands_reopens_a_stalled_socket_and_stops_with_its_sender() -> None:
    async with running("MulticastRobot", "uno") as fleet:
        for direction, speed, left, right in (
            (0, 1, 255, 255),
            (45, 1, 255, 181),
            (-45, 0.5, 91, 128),
            (90, 1, 255, 1),
            (float("nan"), 1, 0, 0),
            (135, 1, -255, -181),
            (0, float("inf"), 0, 0),
            (45, 1.414, 255, 180),
        ):
            async with fleet.driving(direction, speed):
                await fleet.wait_for_wheels(left, right)
        (robot,) = fleet.channel.table.robots.values()
        assert (robot.status.robot_id, robot.address[0]) == (1, "127.0.0.2")
        async with fleet.driving(0, 1):
            await fleet.board.send_command("w5100 stall_after=1")
            await fleet.wait_for_wheels(0, 0)
            stalled_s = fleet.stalled_s()
            async with asyncio.timeout(TIMEOUT_S):
                while fleet.duty_changed_s(1) < stalled_s:
                    await asyncio.sleep(0.01)
            assert fleet.duty_changed_s(1) - stalled_s < 1
            await fleet.board.send_command("w5100 stall_after=0")
            await fleet.wait_for_wheels(255, 255)
        sender_ended_s = await fleet.time_s()
        await fleet.wait_for_wheels(0, 0)
        assert fleet.duty_changed_s(0) - sender_ended_s < TTL_S + GRACE_S


async def test_the_library_is_small(tmp_path: Path) -> None:
    framed = ElfFile.read((await build_example("MulticastRobot", "uno")).elf)
    text = re.sub(r"ros::MulticastCommand<[^;]*EthernetUDP>[^;]*;", BARE_COMMANDS, TEXT)
    bare = ElfFile.read((await build_sketch(write_sketch(tmp_path, "Bare", text), find_board("uno"))).elf)
    is_measured = has_measured_compiler()
    assert framed.flash_bytes - bare.flash_bytes <= (MAX_FLASH if is_measured else MAX_FLASH_NEWER)
    assert framed.ram_bytes - bare.ram_bytes <= (MAX_RAM if is_measured else MAX_RAM_NEWER)


async def test_tags_of_every_length_on_a_board(tmp_path: Path) -> None:
    built = await build_sketch(write_sketch(tmp_path, "Tags", TAGS), find_board("uno"))
    data = bytes(range(TAG_LENGTHS))
    expected = b"".join(siphash_2_4(KEY, data[:length]) for length in range(TAG_LENGTHS))
    async with await SimulatedBoard.start(built.elf, realtime=False) as board, asyncio.timeout(TIMEOUT_S):
        while await board.memory("checked", 1) != bytes([TAG_LENGTHS]):
            await asyncio.sleep(0.01)
        assert await board.memory("tags", len(expected)) == expected

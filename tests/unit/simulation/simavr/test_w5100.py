"""The simulated Ethernet shield with real datagrams: DHCP, groups, answers, and stalls."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from pathlib import Path

import pytest

from rostether.errors import BoardError
from rostether.platform.multicast_socket import GroupAddress, open_sender
from rostether.simulation.simavr.board_events import BoardEvent
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from unit.platform.datagrams import GROUP, loopback_group
from unit.simulation.simavr.programs import build, build_text
from unit.simulation.simavr.readings import named, number

pytestmark = pytest.mark.simavr

TIMEOUT_S = 60.0
# Answers with a second socket: a socket in a group sends only to the group.
ECHO = """
#include <Ethernet.h>
EthernetUDP udp;
volatile uint8_t address, failures;
byte mac[] = {0x00, 0xAA, 0xBB, 0xCC, 0xDE, 0x02};
void setup() {
  if (!Ethernet.begin(mac)) failures++;
  address = Ethernet.localIP()[3];
  Ethernet.setRetransmissionTimeout(10);
  Ethernet.setRetransmissionCount(1);
  udp.beginMulticast(IPAddress(239, 255, 82, 83), GROUP_PORT);
}
void loop() {
  byte bytes[300];
  int size = udp.parsePacket();
  if (!size) return;
  size = udp.read(bytes, size < 300 ? size : 300);
  EthernetUDP answers;
  answers.begin(GROUP_PORT);
  answers.beginPacket(bytes[0] == '!' ? IPAddress(192, 168, 7, 7) : udp.remoteIP(), udp.remotePort());
  answers.write(bytes, size);
  if (!answers.endPacket()) failures++;
  answers.stop();
}
"""
# Uses the chip's registers, like sketches for version 1 of Arduino's library.
REGISTERS = """
#include <Ethernet.h>
#include <utility/w5100.h>
volatile uint8_t heard[20];
byte mac[] = {0x00, 0xAA, 0xBB, 0xCC, 0xDE, 0x02};
byte group[] = {239, 255, 82, 83}, group_mac[] = {0x01, 0x00, 0x5E, 0x7F, 82, 83};
void setup() {
  while (!Ethernet.begin(mac)) {}
  W5100.writeSnDIPR(0, group);
  W5100.writeSnDPORT(0, GROUP_PORT);
  W5100.writeSnDHAR(0, group_mac);
  W5100.writeSnMR(0, SnMR::UDP | SnMR::MULTI);
  W5100.writeSnPORT(0, GROUP_PORT);
  W5100.execCmdSn(0, Sock_OPEN);
}
void loop() {
  if (W5100.getRXReceivedSize(0) < 8) return;
  W5100.recv_data_processing(0, (uint8_t*)heard, 8);
  W5100.recv_data_processing(0, (uint8_t*)heard + 8, heard[7]);
  W5100.execCmdSn(0, Sock_RECV);
}
"""


def in_group(event: BoardEvent) -> bool:
    return bool(event["state"] == "opened") and GROUP in event["at"]


async def start(folder: Path, text: str, group: GroupAddress, *words: str) -> SimulatedBoard:
    program = await build_text(folder, text.replace("GROUP_PORT", str(group.port)))
    board = await SimulatedBoard.start(program, link="none", commands=words)
    if not any(in_group(event) for event in named(board, "w5100")):
        await board.wait_for("w5100", in_group, timeout_s=TIMEOUT_S)
    return board


async def asked(sock: socket.socket, data: bytes, to: tuple[str, int]) -> tuple[bytes, tuple[str, int]]:
    """Send until there is an answer: a datagram may arrive before the board's socket is open."""
    loop = asyncio.get_running_loop()
    async with asyncio.timeout(TIMEOUT_S):
        while True:
            sock.sendto(data, to)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(1):
                    return await loop.sock_recvfrom(sock, 2048)


async def test_a_sketch_gets_an_address_receives_its_group_and_answers(tmp_path: Path) -> None:
    group = loopback_group()
    place = (group.group, group.port)
    with open_sender(group, "127.0.0.1") as sock:
        async with await start(tmp_path, ECHO, group, "w5100 address=127.0.7.3") as board:
            assert await number(board, "address") == 3
            data = bytes(range(200))
            assert await asked(sock, data, place) == (data, ("127.0.7.3", group.port))
            assert await asked(sock, b"to it alone", ("127.0.7.3", group.port)) == (
                b"to it alone",
                ("127.0.7.3", group.port),
            )
            # No machine has the address in another network: the chip gives up.
            sock.sendto(b"!", place)
            async with asyncio.timeout(TIMEOUT_S):
                while await number(board, "failures") == 0:
                    await asyncio.sleep(0.01)
            assert (await asked(sock, b"again", place))[0] == b"again"


async def test_the_registers_of_the_chip_and_its_stall(tmp_path: Path) -> None:
    group = loopback_group()
    with open_sender(group, "127.0.0.1") as sock:
        async with await start(tmp_path, REGISTERS, group, "w5100 stall_after=2") as board:
            for data in (b"first", b"second", b"third"):
                is_last = data == b"third"
                found = asyncio.ensure_future(
                    board.wait_for("w5100", lambda event: event["state"] == "stalled")
                )
                sock.sendto(data, (group.group, group.port))
                if is_last:
                    await found
                    data = b"second"
                expected = (
                    bytes([127, 0, 0, 1, *sock.getsockname()[1].to_bytes(2, "big"), 0, len(data)]) + data
                )
                async with asyncio.timeout(TIMEOUT_S):
                    while not (await board.memory("heard")).startswith(expected):
                        await asyncio.sleep(0.01)
                found.cancel()


@pytest.mark.parametrize(
    "settings",
    ["", "address=10.0.0.1", "address=x", "stall_after=-1", "stall_after=", "dumb=1", "stall_after"],
)
async def test_invalid_settings_are_refused(settings: str) -> None:
    async with await SimulatedBoard.start(build("echo"), link="none") as board:
        with pytest.raises(BoardError, match=r"^w5100 .*: write "):
            await board.send_command(f"w5100 {settings}")

"""The bundled libraries Servo and Ethernet on simulated boards: the width of pulses, and bytes over the
network.
"""

from __future__ import annotations

import asyncio
import subprocess
from pathlib import Path

import pytest

from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.firmware.libraries import SIMULATION_LIBRARIES
from rostether.firmware.toolchain import find_avr_toolchain
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from unit.firmware.sketches import write_sketch

pytestmark = pytest.mark.simavr

SERVO = """
#include <Servo.h>
Servo servos[3];
void setup() {
  servos[0].write(ANGLE);
  servos[0].attach(9);
  servos[1].attach(10, 1000, 2000);
  servos[1].write(180);
  servos[2].attach(6);
  servos[2].writeMicroseconds(700);
}
void loop() { NOISE }
"""
NETWORK = """
#include <Ethernet.h>
byte mac[] = {1, 2, 3, 4, 5, 6};
EthernetClient client;
void setup() {
  Serial.begin(115200);
  Ethernet.begin(mac, IPAddress(192, 168, 0, 177));
  if (Ethernet.localIP() != IPAddress(192, 168, 0, 177)) Serial.print("no address;");
  if (!client.connect(IPAddress(192, 168, 0, 11), 11411)) Serial.print("not connected;");
  client.print("ping");
}
void loop() {
  while (client.available()) {
    int looked = client.peek();
    int byte = client.read();
    if (looked == byte) client.write((uint8_t)(byte + 1));
  }
  if (!client.connected()) { client.stop(); Serial.print("gone;"); delay(1000); }
}
"""


@pytest.mark.parametrize("library", ["Servo", "Ethernet"])
@pytest.mark.parametrize("board", ["uno", "mega", "leonardo"])
def test_they_compile_without_a_warning(tmp_path: Path, library: str, board: str) -> None:
    toolchain, chosen = find_avr_toolchain(), find_board(board)
    source = SIMULATION_LIBRARIES / library / "src" / f"{library}.cpp"
    includes = [f"-I{each}" for each in (*toolchain.core_folders(chosen), source.parent)]
    filled = {
        "{includes}": includes,
        "{source_file}": [str(source)],
        "{object_file}": [str(tmp_path / "x.o")],
    }
    command = [part for each in toolchain.recipe("cpp.o", chosen, "all") for part in filled.get(each, [each])]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    # The headers of the core have some.
    assert [line for line in result.stderr.splitlines() if line.startswith(str(source.parent))] == []


@pytest.mark.parametrize(
    ("board", "angle"), [("uno", 0), ("uno", 57), ("uno", 180), ("mega", 90), ("leonardo", 33)]
)
async def test_the_pulse_width_matches_the_angle(tmp_path: Path, board: str, angle: int) -> None:
    text = SERVO.replace("ANGLE", str(angle)).replace("NOISE", "")
    built = await build_sketch(write_sketch(tmp_path, "S", text), find_board(board))
    async with await SimulatedBoard.start(built.elf, board=board, link="none", paused=True) as simulated:
        await simulated.send_command("servo D9")
        await simulated.run("100ms")
        assert await simulated.servo_angle("D9") == pytest.approx(angle, abs=0.3)


async def test_every_servo_has_its_own_limits(tmp_path: Path) -> None:
    text = SERVO.replace("ANGLE", "90").replace("NOISE", "")
    built = await build_sketch(write_sketch(tmp_path, "S", text), find_board("uno"))
    async with await SimulatedBoard.start(built.elf, board="uno", link="none", paused=True) as simulated:
        for pin in ("D10", "D6"):
            await simulated.send_command(f"servo {pin}")
        await simulated.run("100ms")
        span_us = 2400 - 544
        assert await simulated.servo_angle("D10") == pytest.approx((2000 - 544) / span_us * 180, abs=0.3)
        assert await simulated.servo_angle("D6") == pytest.approx((700 - 544) / span_us * 180, abs=0.3)


async def test_a_busy_serial_line_moves_a_servo_by_less_than_two_degrees(tmp_path: Path) -> None:
    text = SERVO.replace("ANGLE", "90").replace("NOISE", 'Serial.println("as much as goes");')
    text = text.replace("void setup() {", "void setup() { Serial.begin(115200);")
    built = await build_sketch(write_sketch(tmp_path, "S", text), find_board("uno"))
    async with await SimulatedBoard.start(built.elf, board="uno", link="none", paused=True) as simulated:
        await simulated.send_command("servo D9")
        for _ in range(10):
            await simulated.run("50ms")
            assert await simulated.servo_angle("D9") == pytest.approx(90, abs=2)


async def test_a_servo_needs_little_memory(tmp_path: Path) -> None:
    without = await build_sketch(
        write_sketch(tmp_path / "a", "S", "void setup() {}\nvoid loop() {}\n"), find_board("uno")
    )
    text = "#include <Servo.h>\nServo s;\nvoid setup() { s.attach(9); }\nvoid loop() { s.write(millis()); }\n"
    one = await build_sketch(write_sketch(tmp_path / "b", "S", text), find_board("uno"))
    before, after = ElfFile.read(without.elf), ElfFile.read(one.elf)
    assert after.flash_bytes - before.flash_bytes < 1300
    assert after.ram_bytes - before.ram_bytes < 90


async def test_bytes_are_exchanged_over_the_simulated_network(tmp_path: Path) -> None:
    built = await build_sketch(write_sketch(tmp_path, "S", NETWORK), find_board("uno"))
    connected: asyncio.Queue[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = asyncio.Queue()

    async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await connected.put((reader, writer))

    async with asyncio.timeout(60), await asyncio.start_server(accept, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        words = [f"network 127.0.0.1:{port}", "watch serial"]
        async with await SimulatedBoard.start(built.elf, board="uno", commands=words) as simulated:
            reader, writer = await connected.get()
            assert await reader.readexactly(4) == b"ping"
            writer.write(bytes(range(200)))
            assert await reader.readexactly(200) == bytes(range(1, 201))
            writer.close()
            await writer.wait_closed()
            while b"gone;" not in simulated.serial:
                await asyncio.sleep(0.01)
            assert bytes(simulated.serial).startswith(b"gone;")

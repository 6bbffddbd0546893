"""Flash, RAM and stack of the examples, compared with the established library."""

from __future__ import annotations

import asyncio
import statistics
import struct
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from effort import effort
from firmware.examples.stage import build_example, running
from firmware.robustness.scripted_host import ScriptedHost
from rostether.codegen.library_source import client_library
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions
from rostether.firmware.elf import ElfFile
from rostether.rosserial import topic_id

# Flash and static RAM in bytes: avr-gcc 5.4, -Os -flto. The sketches on Ethernet were measured with the
# first version of the simulated Ethernet library; their RAM includes 41 bytes that later versions need.
ESTABLISHED: Mapping[str, Mapping[str, tuple[int, int]]] = {
    "uno": {
        "HelloWorld": (9278, 1362),
        "Blink": (9344, 1360),
        "pubsub": (9904, 1468),
        "ServiceServer": (10272, 1548),
        "ServiceClient": (10352, 1517),
        "Logging": (9506, 1412),
        "TimeTF": (12408, 1826),
        "Odom": (13642, 1838),
        "ServoControl": (10514, 1411),
        "Ultrasound": (11338, 1461),
        "BlinkM": (11498, 1664),
        "BlinkerWithClass": (10314, 1540),
        "Temperature": (9714, 1360),
        "TcpBlink": (9740, 1326),
        "TcpHelloWorld": (10638, 1525),
        "Parameters": (12018, 1804),
    },
    "leonardo": {
        "HelloWorld": (12122, 1976),
        "Blink": (12266, 1976),
        "pubsub": (12868, 2072),
        "ServiceServer": (13094, 2117),
        "ServiceClient": (13302, 2121),
        "Logging": (12238, 2026),
        "TimeTF": (15308, 2426),
        "Odom": (16844, 2442),
        "ServoControl": (13084, 2044),
        "Ultrasound": (14370, 2065),
        "BlinkM": (14524, 2268),
        "BlinkerWithClass": (13440, 2144),
        "Temperature": (12792, 1974),
        "TcpBlink": (12874, 1895),
        "TcpHelloWorld": (12798, 1911),
        "Parameters": (14960, 2408),
    },
}
# The deepest stack of the established library on a simulated Uno is 127 to 138 bytes.
ESTABLISHED_STACK_BYTES = 127
USES_WIRE = frozenset({"BlinkM"})
RAM_BYTES = 2048
_RUN_S = 3
_TIME = struct.pack("<II", 1_700_000_000, 0)
# Static RAM that Wire adds to a sketch on an Uno.
WIRE_RAM_BYTES = 216
_SERIAL = "#ifdef USBCON\n#define Serial Serial1\n#endif\nvoid loop() { Serial.write(Serial.read()); }\n"
_BARE = {
    False: _SERIAL + "void setup() { Serial.begin(57600); }\n",
    True: "#include <Wire.h>\n" + _SERIAL + "void setup() { Serial.begin(57600); Wire.begin(); "
    "Wire.beginTransmission(9); Wire.write(1); Wire.endTransmission(); }\n",
}


@dataclass(frozen=True, slots=True)
class FlashSize:
    """Flash of one example in bytes; `other_bytes` is the flash of Wire and of a USB port."""

    example: str
    bytes: int
    established_bytes: int
    other_bytes: int

    @property
    def part(self) -> float:
        """The flash, as a part of the established library's."""
        return self.bytes / self.established_bytes

    @property
    def ros_part(self) -> float:
        """The flash, as a part of the established library's, both without Wire and USB."""
        return (self.bytes - self.other_bytes) / (self.established_bytes - self.other_bytes)


@dataclass(frozen=True, slots=True)
class RamSize:
    """Static RAM of one example on an Uno, and the deepest stack that it reached, in bytes."""

    example: str
    static_bytes: int
    stack_bytes: int

    def part(self, *, excluded_bytes: int = 0) -> float:
        """RAM and stack, as a part of the established library's; `excluded_bytes` are not counted in
        either.
        """
        established = ESTABLISHED["uno"][self.example][1] + ESTABLISHED_STACK_BYTES
        return (self.static_bytes + self.stack_bytes - excluded_bytes) / (established - excluded_bytes)


def has_measured_compiler() -> bool:
    """Return whether avr-gcc has the version with which the limits of the tests were measured."""
    version = subprocess.run(["avr-gcc", "-dumpversion"], capture_output=True, text=True, check=True)
    return version.stdout.startswith("5.")


async def ram_size(example: str) -> RamSize:
    """Run an example on a simulated Uno, with a host that answers, and measure its RAM and stack."""
    built = await build_example(example, "uno")
    static_bytes = ElfFile.read(built.elf).ram_bytes
    if example.startswith("Tcp"):
        async with running(example, uses_network=True) as stage:
            await asyncio.sleep(_RUN_S)
            free_bytes = await stage.board.free_stack_bytes()
    else:
        host = await ScriptedHost.start(built.elf)
        host.on_frame = lambda each, _payload: (
            host.send(topic_id.TIME, _TIME) if each == topic_id.TIME else None
        )
        async with host.board:
            host.send(topic_id.PUBLISHER)
            await host.run(_RUN_S * 1000)
            free_bytes = await host.board.free_stack_bytes()
    return RamSize(example, static_bytes, RAM_BYTES - static_bytes - free_bytes)


async def flash_sizes(board: str) -> list[FlashSize]:
    """Build and measure the examples for a board; on a Leonardo only some of them, because only the USB port
    differs.
    """
    bare_bytes = await _bare_bytes("uno", uses_wire=False)
    other = {wire: await _bare_bytes(board, uses_wire=wire) - bare_bytes for wire in (False, True)}
    sizes = []
    step = 1 if board == "uno" else effort(3, 1)
    for name, (established_bytes, _) in list(ESTABLISHED[board].items())[::step]:
        # With the options of other tests, so that each is compiled once.
        sketch = client_library() / "examples" / name
        built = await build_sketch(sketch, find_board(board), BuildOptions(warnings=True))
        flash_bytes = ElfFile.read(built.elf).flash_bytes
        sizes.append(FlashSize(name, flash_bytes, established_bytes, other[name in USES_WIRE]))
    return sizes


def median_part(sizes: list[FlashSize]) -> float:
    """Return the median of `ros_part`."""
    return statistics.median(each.ros_part for each in sizes)


async def _bare_bytes(board: str, *, uses_wire: bool) -> int:
    with tempfile.TemporaryDirectory() as folder:
        sketch = Path(folder) / "bare" / "bare.ino"
        sketch.parent.mkdir()
        sketch.write_text(_BARE[uses_wire])
        built = await build_sketch(sketch, find_board(board), BuildOptions(warnings=True))
        return ElfFile.read(built.elf).flash_bytes

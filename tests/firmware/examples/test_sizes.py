"""What the examples take of an Uno, beside the same ones with the established library."""

from __future__ import annotations

import asyncio
import struct
from pathlib import Path

import pytest

from firmware.examples.stage import build_example
from firmware.robustness.scripted_host import ScriptedHost
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.rosserial import topic_id

# Flash and static RAM in bytes with the established library: avr-gcc 5.4, -Os -flto, Uno.
ESTABLISHED = {
    "HelloWorld": (9278, 1362),
    "Blink": (9344, 1360),
    "pubsub": (9904, 1468),
    "ServiceServer": (10272, 1548),
    "Logging": (9506, 1412),
    "TimeTF": (12408, 1826),
    "Odom": (13642, 1838),
    "ServoControl": (10514, 1411),
    "Ultrasound": (11338, 1461),
}
# The deepest stack of the established library on the same simulated board: 127 to 138 bytes.
ESTABLISHED_STACK_BYTES = 127
MOST_FLASH, MOST_RAM = 0.65, 0.50
# Static RAM and the deepest stack together.
MOST_SUM = 0.50
RAM_BYTES = 2048
TIME = struct.pack("<II", 1_700_000_000, 0)
SUBSCRIBERS = """
#include <ros.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>
ros::NodeHandle nh;
std_msgs::Int16 number;
ros::Publisher back("back", &number);
void hear(const std_msgs::Int16& heard) { back.publish(&heard); }
ros::Subscriber<std_msgs::Int16> numbers("numbers", &hear);
void setup() { nh.initNode(); nh.advertise(back); nh.subscribe(numbers); }
void loop() { nh.spinOnce(); delay(1000); }
"""


async def test_examples_are_small(capsys: pytest.CaptureFixture[str]) -> None:
    built = await asyncio.gather(*(build_example(name, "uno") for name in ESTABLISHED))
    lines, too_large = [f"{'Uno':<16}{'flash':>7}{'':>7}{'RAM':>7}"], []
    for each in built:
        name = each.sketch.name
        file = ElfFile.read(each.elf)
        flash, ram = file.flash_bytes / ESTABLISHED[name][0], file.ram_bytes / ESTABLISHED[name][1]
        lines.append(f"{name:<16}{file.flash_bytes:>7}{flash:>7.1%}{file.ram_bytes:>7}{ram:>7.1%}")
        if flash > MOST_FLASH or ram > MOST_RAM:
            too_large.append(lines[-1])
    with capsys.disabled():
        print("\n" + "\n".join(lines))
    assert not too_large, f"of the established library's: at most {MOST_FLASH:.0%} and {MOST_RAM:.0%}"


async def test_static_ram_and_stack_are_half_of_the_established_library_s(
    capsys: pytest.CaptureFixture[str],
) -> None:
    lines, too_large = [f"{'Uno':<16}{'RAM':>7}{'stack':>7}{'sum':>7}"], []
    for name, (_, established_bytes) in ESTABLISHED.items():
        built = await build_example(name, "uno")
        static_bytes = ElfFile.read(built.elf).ram_bytes
        host = await ScriptedHost.start(built.elf)
        host.on_frame = lambda each, _payload, host=host: (
            host.send(10, TIME) if each == topic_id.TIME else None
        )  # type: ignore[misc]
        async with host.board:
            host.send(0)
            await host.run(3000)
            stack_bytes = RAM_BYTES - static_bytes - await host.board.free_stack_bytes()
        total = static_bytes + stack_bytes
        part = total / (established_bytes + ESTABLISHED_STACK_BYTES)
        lines.append(f"{name:<16}{static_bytes:>7}{stack_bytes:>7}{total:>7}{part:>7.1%}")
        if part > MOST_SUM:
            too_large.append(lines[-1])
    with capsys.disabled():
        print("\n" + "\n".join(lines))
    assert not too_large, f"of the established library's: at most {MOST_SUM:.0%}"


async def test_a_sketch_that_sleeps_a_second_answers_many_requests_once(tmp_path: Path) -> None:
    sketch = tmp_path / "Slow" / "Slow.ino"
    sketch.parent.mkdir()
    sketch.write_text(SUBSCRIBERS)
    built = await build_sketch(sketch, find_board("uno"))
    host = await ScriptedHost.start(built.elf)
    async with host.board:
        # While the sketch sleeps, after its first spin.
        await host.run(300)
        for _ in range(4):
            host.send(0)
            await host.run(200)
        await host.run(5000)
    kinds = [each for each, _ in host.frames]
    assert [kinds.count(each) for each in (topic_id.PUBLISHER, topic_id.SUBSCRIBER)] == [1, 1]

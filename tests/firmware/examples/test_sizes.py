"""Flash and RAM of the examples, compared with the established library."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.examples.established import (
    ESTABLISHED,
    USES_WIRE,
    WIRE_RAM_BYTES,
    flash_sizes,
    median_part,
    ram_size,
)
from firmware.robustness.scripted_host import ScriptedHost
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.rosserial import topic_id

# Parts of the established library's flash, without Wire and a Leonardo's USB port.
MAX_FLASH, MAX_MEDIAN_FLASH = 0.65, 0.60
# Parts of its static RAM and deepest stack together, without Wire.
MAX_SUM = 0.50
WITH_STACK = (
    "HelloWorld",
    "Blink",
    "pubsub",
    "ServiceServer",
    "Logging",
    "TimeTF",
    "Odom",
    "ServoControl",
    "Ultrasound",
    "BlinkM",
)
# Static RAM of a node over TCP with one publisher, without its network library; 280 bytes are the input
# buffer.
MAX_TCP_RAM_BYTES = 450
MODEM = """
#define ROSSERIAL_ARDUINO_TCP
#include <IPAddress.h>
#include <ros/node_handle.h>
#include <ros/platform/arduino_tcp_hardware.h>
#include <std_msgs/String.h>
// A client's interface to the registers of the UART, which the compiler cannot remove.
struct Modem {
  int connect(IPAddress, uint16_t) { return UCSR0A; }
  uint8_t connected() { return UCSR0A; }
  int read() { return UDR0; }
  size_t write(const uint8_t* bytes, size_t size) { return UDR0 = bytes[size - 1]; }
  void stop() {}
};
ros::NodeHandle_<ArduinoTcpHardware<Modem>, 25, 25, 280, 280> nh;
std_msgs::String text;
ros::Publisher chatter("chatter", &text);
void setup() {
  nh.getHardware()->setConnection(IPAddress(192, 168, 0, 11));
  nh.initNode();
  nh.advertise(chatter);
}
void loop() {
  chatter.publish(&text);
  nh.spinOnce();
}
"""
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


@pytest.mark.parametrize("board", ESTABLISHED)
async def test_examples_are_small(board: str, capsys: pytest.CaptureFixture[str]) -> None:
    sizes = await flash_sizes(board)
    with capsys.disabled():
        print(f"\n{board:<16}{'flash':>7}{'part':>7}{'ROS':>7}, median {median_part(sizes):.1%}")
        for each in sizes:
            print(f"{each.example:<16}{each.bytes:>7}{each.part:>7.1%}{each.ros_part:>7.1%}")
    assert {each.example: each.ros_part for each in sizes if each.ros_part > MAX_FLASH} == {}
    assert median_part(sizes) <= MAX_MEDIAN_FLASH


async def test_ram_and_stack_are_at_most_half_of_the_established_library(
    capsys: pytest.CaptureFixture[str],
) -> None:
    lines, too_large = [f"{'Uno':<16}{'RAM':>7}{'stack':>7}{'part':>7}"], []
    for name in WITH_STACK:
        size = await ram_size(name)
        part = size.part(excluded_bytes=WIRE_RAM_BYTES if name in USES_WIRE else 0)
        lines.append(f"{name:<16}{size.static_bytes:>7}{size.stack_bytes:>7}{part:>7.1%}")
        if part > MAX_SUM:
            too_large.append(lines[-1])
    with capsys.disabled():
        print("\n" + "\n".join(lines))
    assert not too_large, f"of the established library's: at most {MAX_SUM:.0%}"


async def test_tcp_needs_little_ram_without_the_network_library(tmp_path: Path) -> None:
    sketch = tmp_path / "Modem" / "Modem.ino"
    sketch.parent.mkdir()
    sketch.write_text(MODEM)
    built = await build_sketch(sketch, find_board("uno"))
    assert ElfFile.read(built.elf).ram_bytes <= MAX_TCP_RAM_BYTES


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

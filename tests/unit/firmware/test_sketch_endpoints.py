from __future__ import annotations

from pathlib import Path

import pytest

from rostether.firmware.build import build_sketch
from rostether.firmware.demangle import demangle
from rostether.firmware.elf import ElfFile, Symbol
from rostether.firmware.sketch_endpoints import Endpoint, find_endpoints, input_buffer_bytes
from rostether.msgdef.registry import Registry
from unit.firmware.sketches import uno, write_sketch

pytestmark = pytest.mark.avr

SKETCH = """
#include <ros.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Range.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>

ros::NodeHandle_<ArduinoHardware, 6, 6, 100, 100> nh;
sensor_msgs::Range range;
ros::Publisher out("ultrasound", &range);
void on_speed(const std_msgs::Int16&) {}
void on_text(const std_msgs::String&) {}
void on_odometry(const nav_msgs::Odometry&) {}
void on_switch(const std_srvs::SetBoolRequest& request, std_srvs::SetBoolResponse& response) {
  response.success = request.data;
}
ros::Subscriber<std_msgs::Int16> speed("speed", &on_speed);
ros::Subscriber<std_msgs::String> text("text", &on_text);
ros::Subscriber<nav_msgs::Odometry> odometry("odom", &on_odometry);
ros::ServiceServer<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse> server("set_led", &on_switch);

void setup() {
  nh.initNode();
  nh.advertise(out);
  nh.subscribe(speed);
  nh.subscribe(text);
  nh.subscribe(odometry);
  nh.advertiseService(server);
}
void loop() { out.publish(&range); nh.spinOnce(); }
"""


@pytest.fixture
async def endpoints(tmp_path: Path) -> tuple[dict[str, Endpoint], int]:
    built = await build_sketch(write_sketch(tmp_path, "S", SKETCH), uno())
    elf = ElfFile.read(built.elf)
    readable = await demangle(each.name for each in elf.symbols)
    # The address of a topic's name is, by chance, also that of another endpoint's function.
    (out,) = (each for each in elf.symbols if each.name == "out")
    topic = int.from_bytes(elf.read_at(out.address, 2), "little")
    elf.symbols.append(Symbol("decoy", topic * 2, 2, 2, ".text"))
    readable["decoy"] = "void ros::Publisher::drive<std_msgs::Int16>(ros::Endpoint&)"
    found = find_endpoints(elf, readable, Registry(), built.sources)
    return {each.topic: each for each in found}, input_buffer_bytes(readable)


async def test_topics_and_services_with_their_types(endpoints: tuple[dict[str, Endpoint], int]) -> None:
    found, _ = endpoints
    assert {topic: (each.role, each.type_name) for topic, each in found.items()} == {
        "ultrasound": ("publishes", "sensor_msgs/Range"),
        "speed": ("subscribes", "std_msgs/Int16"),
        "text": ("subscribes", "std_msgs/String"),
        "odom": ("subscribes", "nav_msgs/Odometry"),
        "set_led": ("serves", "std_srvs/SetBool"),
    }


async def test_notes_compare_messages_with_the_input_buffer(
    endpoints: tuple[dict[str, Endpoint], int],
) -> None:
    found, buffer_bytes = endpoints
    assert buffer_bytes == 100
    assert found["speed"].note(buffer_bytes) == "fits"
    assert found["text"].note(buffer_bytes) == "fits with up to 96 bytes of strings and arrays"
    assert found["odom"].note(buffer_bytes) == "never arrives: the buffer has 100 bytes"
    assert found["ultrasound"].note(buffer_bytes) == "sent without a buffer"
    assert found["set_led"].incoming_bytes == 1


async def test_sizes_are_those_of_the_wire(endpoints: tuple[dict[str, Endpoint], int]) -> None:
    found, _ = endpoints
    assert (found["speed"].smallest_bytes, found["speed"].is_fixed) == (2, True)
    assert (found["ultrasound"].smallest_bytes, found["ultrasound"].is_fixed) == (33, False)
    assert (found["odom"].smallest_bytes, found["odom"].is_fixed) == (700, False)


def test_a_program_without_ros_has_no_buffer() -> None:
    assert input_buffer_bytes({"main": "main"}) == 0

"""The parts of the client library that ROBOTIS' firmware uses, in a sketch on a simulated OpenCR."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from firmware.platforms.node_harness import node_harness
from rostether.errors import BoardError
from rostether.firmware.opencr_build import build_for_linux
from rostether.simulation.opencr.board import BLUETOOTH, OpenCrBoard
from rostether.simulation.opencr.commands import execute
from rostether.simulation.opencr.node_board import OpenCrNodeBoard
from waiting import until

pytestmark = pytest.mark.gcc

SKETCH = """\
#include <ros.h>
#include <ros/time.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Int32.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/BatteryState.h>
#include <sensor_msgs/MagneticField.h>
#include <geometry_msgs/Vector3.h>
#include <geometry_msgs/Twist.h>
#include <tf/tf.h>
#include <tf/transform_broadcaster.h>
#include <nav_msgs/Odometry.h>
#include <turtlebot3_msgs/SensorState.h>
#include <turtlebot3_msgs/Sound.h>
#include <turtlebot3_msgs/VersionInfo.h>

#define DEBUG_SERIAL SerialBT2

// Declared before the node handle, as a header does.
void steer(const geometry_msgs::Twist& twist);
void beep(const turtlebot3_msgs::Sound& sound);
void power(const std_msgs::Bool& on);
void restart(const std_msgs::Empty& empty);
ros::Time stamp(void);

ros::NodeHandle nh;
char given[10];
char* prefix = given;
char frame[30];

// Functions without &.
ros::Subscriber<geometry_msgs::Twist> steering("cmd_vel", steer);
ros::Subscriber<turtlebot3_msgs::Sound> sounds("sound", beep);
ros::Subscriber<std_msgs::Bool> powers("motor_power", power);
ros::Subscriber<std_msgs::Empty> restarts("reset", restart);

turtlebot3_msgs::SensorState state;
ros::Publisher states("sensor_state", &state);
turtlebot3_msgs::VersionInfo version;
ros::Publisher versions("firmware_version", &version);
sensor_msgs::Imu imu;
ros::Publisher imus("imu", &imu);
geometry_msgs::Twist remote;
ros::Publisher remotes("cmd_vel_rc100", &remote);
nav_msgs::Odometry odom;
ros::Publisher odoms("odom", &odom);
sensor_msgs::JointState joints;
ros::Publisher jointStates("joint_states", &joints);
sensor_msgs::BatteryState battery;
ros::Publisher batteries("battery_state", &battery);
sensor_msgs::MagneticField field;
ros::Publisher fields("magnetic_field", &field);
geometry_msgs::TransformStamped transform;
tf::TransformBroadcaster broadcaster;

bool asked = false;
float speed = 0;

// Messages as results and as members of classes.
class Sensors {
 public:
  sensor_msgs::Imu measure(void) {
    message_.angular_velocity.z = speed;
    message_.angular_velocity_covariance[0] = 0.02;
    message_.angular_velocity_covariance[4] = 0.02;
    message_.orientation.w = 1;
    return message_;
  }
 private:
  sensor_msgs::Imu message_;
};
Sensors sensors;

void setup() {
  DEBUG_SERIAL.begin(57600);
  nh.initNode();
  // After initNode.
  nh.getHardware()->setBaud(115200);
  nh.subscribe(steering);
  nh.subscribe(sounds);
  nh.subscribe(powers);
  nh.subscribe(restarts);
  nh.advertise(states);
  nh.advertise(versions);
  nh.advertise(imus);
  nh.advertise(remotes);
  nh.advertise(odoms);
  nh.advertise(jointStates);
  nh.advertise(batteries);
  nh.advertise(fields);
  broadcaster.init(nh);
  static char* names[] = {(char*)"wheel_left_joint", (char*)"wheel_right_joint"};
  joints.name = names;
  joints.name_length = 2;
  joints.position_length = 2;
  joints.velocity_length = 2;
  joints.effort_length = 2;  // without efforts
}

void publishAll(void) {
  static float positions[2] = {0.0, 0.0};
  static float velocities[2] = {0.0, 0.0};
  positions[0] = 1.5;
  joints.position = positions;
  joints.velocity = velocities;
  joints.header.stamp = stamp();
  jointStates.publish(&joints);

  imu = sensors.measure();
  imu.header.stamp = stamp();
  imu.header.frame_id = frame;
  imus.publish(&imu);

  odom.header.frame_id = frame;
  odom.child_frame_id = "base_footprint";
  odom.pose.pose.orientation = tf::createQuaternionFromYaw(0.5);
  odom.twist.twist.linear.x = speed;
  odom.header.stamp = stamp();
  odoms.publish(&odom);
  transform.header = odom.header;
  transform.child_frame_id = odom.child_frame_id;
  transform.transform.translation.x = odom.pose.pose.position.x;
  transform.transform.rotation = odom.pose.pose.orientation;
  broadcaster.sendTransform(transform);

  state.header.stamp = stamp();
  state.left_encoder = -5;
  state.torque = true;
  states.publish(&state);
  battery.design_capacity = 1.8f;
  battery.voltage = 11.1f;
  battery.percentage = (float)(battery.voltage / 11.1f);
  battery.present = true;
  batteries.publish(&battery);
  field.magnetic_field.x = 20e-6;
  fields.publish(&field);
  remotes.publish(&remote);
  version.hardware = "0.0.0";
  version.software = "0.0.0";
  version.firmware = "1.2.3";
  versions.publish(&version);
}

void loop() {
  static uint32_t last = 0;
  if (nh.connected() && !asked) {
    nh.getParam("~tf_prefix", &prefix);
    if (!strcmp(prefix, "")) {
      sprintf(frame, "odom");
    } else {
      strcpy(frame, prefix);
      strcat(frame, "/odom");
    }
    char text[50];
    String firmware = "1.2.3";
    String line = "This core(v" + firmware + ") is compatible with TB3 " + String("Burger");
    nh.loginfo(line.c_str());
    DEBUG_SERIAL.println("Button : " + String(getPushButton()));
    DEBUG_SERIAL.print("     theta : "); DEBUG_SERIAL.println(speed);
    sprintf(text, "Setup TF on Odometry [%s]", frame);
    nh.loginfo(text);
    asked = true;
  }
  if (millis() - last >= 50) {
    last = millis();
    publishAll();
  }
  nh.spinOnce();
}

ros::Time stamp(void) { return nh.now(); }
void steer(const geometry_msgs::Twist& twist) { speed = constrain(twist.linear.x, -0.22, 0.22); }
void beep(const turtlebot3_msgs::Sound& sound) { if (sound.value == 1) tone(BDPIN_BUZZER, 262, 250); }
void power(const std_msgs::Bool& on) { digitalWrite(BDPIN_DXL_PWR_EN, on.data); }
void restart(const std_msgs::Empty& empty) { (void)(empty); speed = 0; }
"""
TYPES = {
    "sensor_state": "turtlebot3_msgs/SensorState",
    "firmware_version": "turtlebot3_msgs/VersionInfo",
    "imu": "sensor_msgs/Imu",
    "cmd_vel_rc100": "geometry_msgs/Twist",
    "odom": "nav_msgs/Odometry",
    "joint_states": "sensor_msgs/JointState",
    "battery_state": "sensor_msgs/BatteryState",
    "magnetic_field": "sensor_msgs/MagneticField",
    "tf": "tf/tfMessage",
}


async def _check_interface_of_the_dashboard(node_board: OpenCrNodeBoard) -> None:
    """Use the board like the page of the dashboard."""
    pins = await node_board.pins()
    assert [pins[name] for name in ("DXL_PWR_EN", "LED_USER_1", "PUSH_SW_1")] == ["out1", "out1", "in0"]
    for command, state in (("1", "in1"), ("z", "in0")):
        await node_board.send_command(f"pin PUSH_SW_1={command}")
        assert (await node_board.pins())["PUSH_SW_1"] == state
    with pytest.raises(BoardError, match="no pin 'D99'"):
        await node_board.send_command("pin D99=1")
    assert (await node_board.ask("wheels", "wheels"))["heading_rad"] == 0


async def test_a_sketch_with_the_same_api_works(tmp_path: Path) -> None:
    sketch = tmp_path / "core" / "core.ino"
    sketch.parent.mkdir()
    sketch.write_text(SKETCH)
    program = await build_for_linux(sketch)
    last: dict[str, Any] = {}
    printed: list[str] = []
    async with node_harness() as harness, await OpenCrBoard.start(program) as board:
        execute(board, "watch bluetooth")
        board.on_event = lambda event: printed.append(event["text"]) if event.name == BLUETOOTH else None
        await harness.graph.set_param("/core/tf_prefix", "tb3_1")

        async def collect(topic: str) -> None:
            async for message in harness.graph.messages(f"/{topic}", TYPES[topic]):
                last[topic] = message

        tasks = [asyncio.ensure_future(collect(topic)) for topic in TYPES]
        async with harness.bridge(f"{board.address}?name=core"):
            for topic, kind, fields in (
                ("/cmd_vel", "geometry_msgs/Twist", {"linear": {"x": 1.0}}),
                ("/sound", "turtlebot3_msgs/Sound", {"value": 1}),
                ("/motor_power", "std_msgs/Bool", {"data": True}),
            ):
                publisher = await harness.graph.publisher(topic, kind)
                assert await publisher.wait_for_subscriber(60)
                publisher.publish(**fields)
            await until(lambda: last.keys() == TYPES.keys(), "each topic")
            await until(lambda: board.tones and board.pins.get(32), "the tone and the power")
            await _check_interface_of_the_dashboard(OpenCrNodeBoard(board))
            await until(lambda: last["odom"].twist.twist.linear.x > 0.2, "the speed")
            await until(lambda: len(printed) == 2, "what the sketch prints")
            # The command may arrive before the parameter.
            assert printed in (["Button : 0", f"     theta : {speed}"] for speed in ("0.00", "0.22"))
            await until(lambda: last["odom"].header.frame_id == "tb3_1/odom", "the prefix")
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    assert list(last["joint_states"].position) == [1.5, 0]
    # The sketch sets a length, and no efforts.
    assert list(last["joint_states"].effort) == []
    assert last["odom"].pose.pose.orientation.z == pytest.approx(0.2474, abs=1e-4)
    assert last["sensor_state"].left_encoder == -5
    assert last["battery_state"].percentage == pytest.approx(1)
    assert (last["firmware_version"].firmware, last["tf"].transforms[0].child_frame_id) == (
        "1.2.3",
        "base_footprint",
    )
    assert harness.reporter.having("This core(v1.2.3) is compatible with TB3 Burger")
    assert harness.reporter.having("Setup TF on Odometry [tb3_1/odom]")

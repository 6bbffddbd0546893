"""Idioms of sketches for the established library that its examples do not contain: they compile unchanged."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.firmware.build import build_sketch, find_board

# Parts of sketches that did not compile with an earlier version.
SKETCHES = {
    "header_beside_ros": """
// A sketch's own constants may come first: none is a name in the library.
#define NOTHING 0
#define WAITING 1
#define FOUND 2
#define NOISE 3
#define MAX_DEPTH 4
#define INTS 5
#define LARGEST 6
#include <ArduinoHardware.h>
#include <ros.h>
#include <geometry_msgs/Twist.h>
ros::NodeHandle nh;
void drive(const geometry_msgs::Twist& msg) { digitalWrite(13, msg.linear.x > 0); }
ros::Subscriber<geometry_msgs::Twist> sub("cmd_vel", &drive);
void setup() { nh.initNode(); nh.subscribe(sub); }
void loop() { nh.spinOnce(); }
""",
    "node_handle_alone": """
#include <Arduino.h>
#include <ros/node_handle.h>
#include <std_msgs/Int32.h>
class Port {
 public:
  void init() { Serial.begin(57600); }
  int read() { return Serial.read(); }
  void write(uint8_t* data, int length) { Serial.write(data, length); }
  unsigned long time() { return millis(); }
};
ros::NodeHandle_<Port, 5, 5, 150, 150> nh;
void take(const std_msgs::Int32&) {}
ros::Subscriber<std_msgs::Int32> sub("number", &take, 1);
std_msgs::Int32 number;
ros::Publisher pub("number_back", &number);
void setup() { nh.initNode(); nh.subscribe(sub); nh.advertise(pub); }
void loop() { pub.publish(&number); nh.spinOnce(); }
""",
    "service_by_its_types": """
#include <ros.h>
#include <std_srvs/Trigger.h>
ros::NodeHandle nh;
class Motor {
 public:
  void stop(const std_srvs::TriggerRequest&, std_srvs::TriggerResponse& answer) { answer.success = true; }
};
Motor motor;
typedef std_srvs::TriggerRequest Request;
typedef std_srvs::TriggerResponse Response;
ros::ServiceServer<Request, Response, Motor> stop("stop", &Motor::stop, &motor);
ros::ServiceClient<Request, Response> client("start");
void setup() {
  nh.initNode();
  nh.advertiseService<Request, Response, Motor>(stop);
  nh.serviceClient<Request, Response>(client);
}
void loop() { nh.spinOnce(); }
""",
    # Elements of a float64[] have the type of a float, even in a macro; the array is a pointer.
    "float64_array_as_a_pointer": """
#include <ros.h>
#include <sensor_msgs/JointState.h>
ros::NodeHandle nh;
template <class T> struct IsFloat { static const bool value = false; };
template <> struct IsFloat<float> { static const bool value = true; };
sensor_msgs::JointState last;
float kept[2];
void move(const sensor_msgs::JointState& msg) {
  static_assert(IsFloat<decltype(constrain(msg.position[0], -1, 1))>::value, "not the limits' type");
  static_assert(IsFloat<decltype(max(0, last.position[0]))>::value, "not the limit's type");
  memcpy(kept, msg.position, sizeof kept);
  for (float* each = msg.velocity; each < msg.velocity + msg.velocity_length; ++each) kept[0] += *each;
  if (msg.effort == NULL) last.effort = NULL;
  last.position = kept;
  last.position[0]++;
  last.position[1] /= 2;
}
ros::Subscriber_* sub = new ros::Subscriber<sensor_msgs::JointState>("joints", &move);
void add(ros::Subscriber_& each) { nh.subscribe(each); }
void setup() { nh.initNode(); add(*sub); }
void loop() { nh.spinOnce(); }
""",
    # The advice for boards with little memory: a ros::NodeHandle with smaller buffers.
    "node_handle_of_the_sketch": """
#include "ros/node_handle.h"
#include "ArduinoHardware.h"
namespace ros {
typedef NodeHandle_<ArduinoHardware, 4, 4, 100, 100> NodeHandle;
}
#include <std_msgs/String.h>
#include <tf/transform_broadcaster.h>
ros::NodeHandle nh;
static_assert(ros::NodeHandle::INPUT_BYTES == 100, "not the node handle of the sketch");
tf::TransformBroadcaster broadcaster;
void setup() { nh.initNode(); broadcaster.init(nh); }
void loop() { nh.spinOnce(); }
""",
    "class_from_the_node_handle": """
#include <ros.h>
#include <std_msgs/Int16.h>
class Node : public ros::NodeHandle_<ArduinoHardware, 2, 2, 100, 100> {
 public:
  Node() { hardware_.setBaud(115200); }
};
Node nh;
std_msgs::Int16 number;
ros::Publisher pub("number", &number);
void setup() { nh.initNode(); nh.advertise(pub); }
void loop() { nh.publish(pub.id_, &number); nh.spinOnce(); }
""",
    # The Arduino IDE accepts these callbacks, too.
    "callbacks_of_services": """
#include <ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
ros::NodeHandle nh;
using std_srvs::SetBool;
using std_srvs::Trigger;
void set(SetBool::Request& request, SetBool::Response& answer) { answer.success = request.data; }
bool pull(const Trigger::Request&, Trigger::Response& answer) { return answer.success = true; }
ros::ServiceServer<SetBool::Request, SetBool::Response> setter("set", &set);
ros::ServiceServer<Trigger::Request, Trigger::Response> trigger("pull", pull);
const float rate = 1;
void setup() {
  nh.initNode();
  nh.advertiseService(setter);
  nh.advertiseService(trigger);
  nh.getParam("~rate", &rate);
}
void loop() { nh.spinOnce(); }
""",
}


@pytest.mark.avr
@pytest.mark.parametrize("name", SKETCHES)
async def test_compiles_unchanged(name: str, tmp_path: Path) -> None:
    sketch = tmp_path / name / f"{name}.ino"
    sketch.parent.mkdir()
    sketch.write_text(SKETCHES[name])
    built = await build_sketch(sketch, find_board("uno"))
    assert built.elf.is_file()

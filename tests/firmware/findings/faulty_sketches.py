"""Sketches with common faults, which are built and run on simulated boards."""

from __future__ import annotations

_NODE = """
#include <ros.h>
#include <std_msgs/String.h>
#include <std_msgs/Empty.h>

ros::NodeHandle nh;
std_msgs::String text;
ros::Publisher chatter("chatter", &text);
void take(const std_msgs::Empty&) {}
ros::Subscriber<std_msgs::Empty> toggle("toggle", &take);

void begin() {
  nh.initNode();
  nh.advertise(chatter);
  nh.subscribe(toggle);
}

void talk() {
  static unsigned long due;
  if (millis() - due >= 50) {
    due = millis();
    text.data = "hello";
    chatter.publish(&text);
  }
  nh.spinOnce();
}
"""

HEALTHY = (
    _NODE
    + """
void setup() { begin(); }
void loop() { talk(); }
"""
)

USES_115200_BAUD = (
    _NODE
    + """
void setup() {
  nh.getHardware()->setBaud(115200);
  begin();
}
void loop() { talk(); }
"""
)

SENDS_NOTHING = """
void setup() { Serial.begin(57600); }
void loop() { if (Serial.available()) digitalWrite(13, Serial.read() & 1); }
"""

PRINTS = """
void setup() { Serial.begin(57600); }
void loop() {
  Serial.print("Temperature: ");
  Serial.print(analogRead(0) * 0.49);
  Serial.println(" C");
  delay(200);
}
"""

PRINTS_BESIDE_THE_NODE = (
    _NODE
    + """
void setup() { begin(); }
void loop() {
  static unsigned long due;
  if (millis() - due >= 300) {
    due = millis();
    Serial.print("distance ");
    Serial.print(analogRead(0));
    Serial.println(" cm");
  }
  talk();
}
"""
)

SENDS_NOISE = """
void setup() { Serial.begin(57600); randomSeed(7); }
void loop() {
  for (int i = 0; i < 20; i++) Serial.write(random(256));
  delay(20);
}
"""

WAITS_IN_ITS_LOOP = (
    _NODE
    + """
void setup() { begin(); }
void loop() {
  talk();
  delay(800);
}
"""
)

HANGS_AFTER_SECONDS = (
    _NODE
    + """
void setup() { begin(); }
void loop() {
  talk();
  if (millis() > 2500) for (;;) delay(1);
}
"""
)

# Its measurement takes longer than the time of its watchdog.
IS_RESET_BY_ITS_WATCHDOG = (
    _NODE
    + """
#include <avr/wdt.h>
void setup() {
  begin();
  wdt_enable(WDTO_2S);
}
void loop() {
  static unsigned long fed;
  if (millis() < 1000) wdt_reset();
  talk();
}
"""
)

# Five elements are written behind the end of an array of four, where the topic's name is.
OVERRUNS_AN_ARRAY = """
#include <ros.h>
#include <std_msgs/Float32.h>

ros::NodeHandle nh;
std_msgs::Float32 mean;
struct {
  float recent[4];
  char topic[20];
} state = {{0}, "temperature_mean"};
ros::Publisher publisher(state.topic, &mean);
volatile uint8_t count = 7;

void setup() {
  nh.initNode();
  for (uint8_t i = 0; i < count; i++) state.recent[i] = 19.7f + i;
  nh.advertise(publisher);
}

void loop() {
  static unsigned long due;
  if (millis() - due >= 100) {
    due = millis();
    mean.data = state.recent[0];
    publisher.publish(&mean);
  }
  nh.spinOnce();
}
"""

NAMES_A_TOPIC_WITH_A_SPACE = (
    _NODE.replace('"chatter"', '"my chatter"')
    + """
void setup() { begin(); }
void loop() { talk(); }
"""
)

HAS_A_SMALL_INPUT_BUFFER = """
#include <ros.h>
#include <geometry_msgs/PoseWithCovariance.h>

ros::NodeHandle_<ArduinoHardware, 3, 3, 100, 100> nh;
void take(const geometry_msgs::PoseWithCovariance&) {}
ros::Subscriber<geometry_msgs::PoseWithCovariance> goal("goal", &take);
void setup() { nh.initNode(); nh.subscribe(goal); }
void loop() { nh.spinOnce(); }
"""

# As libraries for LED strips do: meanwhile, the interrupts of the clock are lost.
STOPS_ITS_CLOCK_FOR_A_LED_STRIP = """
#include <ros.h>
#include <sensor_msgs/Range.h>

ros::NodeHandle nh;
sensor_msgs::Range range;
ros::Publisher publisher("range", &range);

void setup() { nh.initNode(); nh.advertise(publisher); }

void loop() {
  static unsigned long due;
  if (millis() - due >= 50) {
    due = millis();
    range.header.stamp = nh.now();
    publisher.publish(&range);
    noInterrupts();
    delayMicroseconds(2600);
    interrupts();
  }
  nh.spinOnce();
}
"""

_MISTAKEN_CLASS = """
#include <ros.h>

class Count : public ros::Msg {
 public:
  int serialize(unsigned char* out) const { for (int i = 0; i < SIZE; i++) out[i] = i; return SIZE; }
  int deserialize(unsigned char*) { return SIZE; }
  const char* getType() { return "std_msgs/Int32"; }
  const char* getMD5() { return "da5909fbe378aeaf85e547e830cc1bb7"; }
};

ros::NodeHandle nh;
Count count;
ros::Publisher publisher("count", &count);
void setup() { nh.initNode(); nh.advertise(publisher); }
void loop() {
  static unsigned long due;
  if (millis() - due >= 100) { due = millis(); publisher.publish(&count); }
  nh.spinOnce();
}
"""

WRITES_TOO_FEW_BYTES = _MISTAKEN_CLASS.replace("SIZE", "3")
WRITES_TOO_MANY_BYTES = _MISTAKEN_CLASS.replace("SIZE", "12")

_WITHOUT_THE_LIBRARY = """
uint8_t buffer[160];

void frame(uint16_t id, const uint8_t* data, uint16_t size) {
  uint8_t sum = (id & 0xff) + (id >> 8);
  Serial.write((uint8_t)0xff);
  Serial.write((uint8_t)VERSION);
  if (VERSION == 0xff) {
    Serial.write(id & 0xff);
    Serial.write(id >> 8);
    sum += (size & 0xff) + (size >> 8);
  }
  Serial.write(size & 0xff);
  Serial.write(size >> 8);
  if (VERSION != 0xff) {
    Serial.write((uint8_t)(255 - ((size & 0xff) + (size >> 8))));
    Serial.write(id & 0xff);
    Serial.write(id >> 8);
  }
  for (uint16_t i = 0; i < size; i++) sum += data[i];
  Serial.write(data, size);
  Serial.write((uint8_t)(255 - sum));
}

uint16_t text(uint16_t place, const char* value) {
  uint16_t size = strlen(value);
  memset(buffer + place, 0, 4);
  buffer[place] = size;
  memcpy(buffer + place + 4, value, size);
  return place + 4 + size;
}

void announce() {
  buffer[0] = 125;
  buffer[1] = 0;
  uint16_t place = text(text(text(2, "chatter"), TYPE), MD5SUM);
  memset(buffer + place, 0, 4);
  buffer[place] = BUFFER;
  frame(0, buffer, place + 4);
}

void askTime() {
  memset(buffer, 0, 8);
  frame(10, buffer, 8);
}

void setup() { Serial.begin(57600); }

void loop() {
  static unsigned long asked, sent;
  static uint32_t last;
  while (Serial.available()) {
    last = last << 8 | Serial.read();
    // The end of a request for topics.
    if (last == (VERSION == 0xff ? 0x000000ff : 0xff0000ff)) {
      askTime();
      announce();
    }
  }
  if (millis() - asked >= 2500) {
    asked = millis();
    askTime();
  }
  if (millis() - sent >= 300) {
    sent = millis();
    memset(buffer, 'x', SIZE);
    memset(buffer, 0, 4);
    buffer[0] = SIZE - 4;
    frame(ID, buffer, SIZE);
  }
}
"""


def _sketch_without_library(
    *,
    version: int = 0xFE,
    type_name: str = "std_msgs/String",
    md5sum: str = "992ce8a1687cec8c8bd883ec73ca41d1",
    buffer: int = 64,
    topic_id: int = 125,
    size: int = 20,
) -> str:
    """Return a sketch that implements the protocol without a library, with a mistake."""
    constants = {
        "VERSION": version,
        "TYPE": f'"{type_name}"',
        "MD5SUM": f'"{md5sum}"',
        "BUFFER": buffer,
        "ID": topic_id,
        "SIZE": size,
    }
    return "".join(f"#define {name} {value}\n" for name, value in constants.items()) + _WITHOUT_THE_LIBRARY


PROTOCOL_VERSION_1 = _sketch_without_library(version=0xFF)
UNKNOWN_PROTOCOL_VERSION = _sketch_without_library(version=0xFC)
SENDS_MORE_THAN_IT_ANNOUNCED = _sketch_without_library(size=100)
SENDS_WHAT_IT_NEVER_ANNOUNCED = _sketch_without_library(topic_id=140)
HAS_A_SMALL_OUTPUT_BUFFER = _sketch_without_library(
    type_name="sensor_msgs/Imu", md5sum="6a62c6daae103f4ff57a132d6f95cec2"
)

ARM = """
#include <ros.h>
#include <my_robot/Arm.h>

ros::NodeHandle nh;
my_robot::Arm arm;
ros::Publisher publisher("arm", &arm);
void setup() { nh.initNode(); nh.advertise(publisher); }
void loop() { nh.spinOnce(); }
"""

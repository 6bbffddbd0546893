// MulticastRobot: one robot of a fleet. Its two motors obey commands from a multicast group, and stop without them.
//
// Wiring:  an Ethernet shield (W5100, W5500) on an Uno; an ESP32 or Uno R4 WiFi needs none.
//          Motor driver, right: direction on pin 7, PWM on 9; left: direction on 8, PWM on 3. ESP32: 26, 25, 33, 32.
// Try it:  rostether fleet drive 1 --speed 0.5 --for 2 --key-file fleet.key
//          where fleet.key contains the key below; make your own with: openssl rand -hex 16 > fleet.key

#if defined(ESP32)
#define HAS_WIFI
#include <WiFi.h>
#include <WiFiUdp.h>
#elif defined(ARDUINO_UNOWIFIR4)
#define HAS_WIFI
#include <WiFiS3.h>
#include <WiFiUdp.h>
#else
#include <SPI.h>
#include <Ethernet.h>
#include <EthernetUdp.h>
#endif

#include <ros/multicast_command.h>
#include <arduino_control/ArduinoControl.h>

#define ROBOT 1  // another number for each robot
#define KEY "0f1e2d3c4b5a69788796a5b4c3d2e1f0"

const IPAddress group(239, 255, 82, 83);
const uint16_t port = 11412;

struct Motor {
  uint8_t direction_pin;
  uint8_t pwm_pin;
};
#if defined(ESP32)
const Motor right = {26, 25};
const Motor left = {33, 32};
#else
const Motor right = {7, 9};
const Motor left = {8, 3};
const uint8_t SD_CARD_PIN = 4;  // of the shield: high deselects the card
#endif

void turn(const Motor& motor, int speed) {
  digitalWrite(motor.direction_pin, speed < 0 ? HIGH : LOW);
  analogWrite(motor.pwm_pin, abs(speed));
}

void halt() {
  turn(left, 0);
  turn(right, 0);
}

// 0 degrees is forward, 90 right, 180 back; speed 1 is the whole supply voltage.
void drive(const arduino_control::ArduinoControl& command) {
  if (!(fabs(command.dir) <= 180 && command.speed >= 0 && command.speed <= 2)) return halt();
  const float outer = ceil(255 * command.speed);
  const float inner = ceil(255 * command.speed * fabs(cos(command.dir * DEG_TO_RAD)));
  const float scale = (outer > 255 ? 255 / outer : 1) * (fabs(command.dir) > 90 ? -1 : 1);
  turn(left, (command.dir > 0 ? outer : inner) * scale);
  turn(right, (command.dir > 0 ? inner : outer) * scale);
}

const ros::FleetKey key ROS_FLASH(KEY);
#if defined(HAS_WIFI)
ros::MulticastCommand<arduino_control::ArduinoControl, WiFiUDP> commands(&drive, &halt, key);

void connect() {
  WiFi.begin("network", "password");
#if defined(ESP32)
  WiFi.setSleep(false);  // a radio that sleeps receives multicast late
#endif
  while (WiFi.status() != WL_CONNECTED) delay(100);
}

void watchNetwork() {
  static unsigned long looked_ms;
  if (millis() - looked_ms < 1000) return;
  looked_ms = millis();
  if (WiFi.status() == WL_CONNECTED) commands.setSignal(WiFi.RSSI());
  else if (!commands.isMoving()) connect();
}
#else
ros::MulticastCommand<arduino_control::ArduinoControl, EthernetUDP> commands(&drive, &halt, key);

void connect() {
  byte mac[] = {0x00, 0xAA, 0xBB, 0xCC, 0xDE, ROBOT};
  while (!Ethernet.begin(mac)) {}
  // The motors are running: do not wait long for the address of a sender that has disappeared.
  Ethernet.setRetransmissionTimeout(20);
  Ethernet.setRetransmissionCount(1);
}

void watchNetwork() {
  // This may block until the DHCP server answers.
  if (!commands.isMoving()) Ethernet.maintain();
}
#endif

void setup() {
  pinMode(left.direction_pin, OUTPUT);
  pinMode(left.pwm_pin, OUTPUT);
  pinMode(right.direction_pin, OUTPUT);
  pinMode(right.pwm_pin, OUTPUT);
#if !defined(HAS_WIFI)
  pinMode(SD_CARD_PIN, OUTPUT);
  digitalWrite(SD_CARD_PIN, HIGH);
#endif
  connect();
  commands.setRobot(ROBOT);
  commands.begin(group, port);
}

void loop() {
  commands.spinOnce();
  watchNetwork();
}

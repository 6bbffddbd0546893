// The two XL430 servos of a TurtleBot3 Burger: converts speeds to commands, and wheel angles to odometry.
#ifndef WHEELS_H
#define WHEELS_H

#include <Arduino.h>
#include <dynamixel/bus.h>
#include <dynamixel/x_series.h>

const float WHEEL_RADIUS = 0.033;      // m
const float WHEEL_SEPARATION = 0.160;  // m
const float MAX_SPEED = 0.22;          // m/s
const float MAX_TURN_RATE = 2.84;      // rad/s
const uint32_t COMMAND_LIFE_MS = 500;  // after this time without a new command, the robot stops

// The longest silence of a servo. Simulated servos are programs, and may need more time.
#if !defined(DYNAMIXEL_TIMEOUT_US)
#define DYNAMIXEL_TIMEOUT_US 5000
#endif

// The board's connectors for servos: Serial3, with a signal that switches between sending and receiving.
class DynamixelPort {
 public:
  void begin() {
    pinMode(BDPIN_DXL_PWR_EN, OUTPUT);
    digitalWrite(BDPIN_DXL_PWR_EN, HIGH);
    Serial3.begin(1000000);
    drv_dxl_tx_enable(FALSE);
    delay(300);  // until the servos have started
  }
  void write(const uint8_t* bytes, size_t size) {
    drv_dxl_tx_enable(TRUE);
    Serial3.write(bytes, size);
    Serial3.flush();
    drv_dxl_tx_enable(FALSE);
  }
  int read() { return Serial3.available() > 0 ? Serial3.read() : -1; }
  uint32_t microseconds() { return micros(); }
  void idle() { delayMicroseconds(20); }
};

struct Wheel {
  int32_t ticks;
  float angle;  // rad, since the start
  float speed;  // rad/s
  float load;   // a fraction of the full torque, -1 to 1
  float volts;
  uint8_t celsius;
  uint8_t hardware_error;
  bool has_torque;
};

class Wheels {
 public:
  Wheels() : bus_(port_, DYNAMIXEL_TIMEOUT_US) {}

  Wheel left, right;
  float x, y, heading;     // m, m, rad since the start or the last reset
  float speed, turn_rate;  // m/s, rad/s
  bool has_failed;         // a servo does not answer
  uint32_t failures;       // failed requests since the start

  void begin() {
    port_.begin();
    setTorque(true);
  }

  void resetOdometry() { x = y = heading = 0; }

  // Switches the torque. Without it, the wheels turn freely. With it, a servo that stopped because of a hardware error
  // starts again. If a servo fails to do this, `measure` tries again.
  void setTorque(bool on) {
    wants_torque_ = on;
    for (uint8_t i = 0; i < 2; ++i) {
      if (on && wheel(i).hardware_error) {
        note(bus_.reboot(IDS[i]));
        is_known_ = false;
      } else {
        if (on) prepare(IDS[i]);
        else release(IDS[i]);
      }
    }
  }
  bool hasTorque() const { return left.has_torque && right.has_torque; }

  // Sends the speeds of a command, in m/s and rad/s.
  void drive(float forward, float turn) {
    // Servos would refuse a speed that is not a number, and keep the last one.
    if (isnan(forward) || isnan(turn)) forward = turn = 0;
    forward = constrain(forward, -MAX_SPEED, MAX_SPEED);
    turn = constrain(turn, -MAX_TURN_RATE, MAX_TURN_RATE);
    const float side = turn * WHEEL_SEPARATION / 2;
    const int32_t speeds[] = {toUnits(forward - side), toUnits(forward + side)};
    bus_.syncWrite(dynamixel::GOAL_VELOCITY, 4, IDS, speeds, 2);
  }

  // Reads both servos, and adds the distance since the last call. Returns false if they do not answer.
  bool measure() {
    uint8_t bytes[2 * BLOCK_BYTES];
    has_failed = !note(bus_.syncRead(dynamixel::TORQUE_ENABLE, BLOCK_BYTES, IDS, bytes, 2));
    if (has_failed) return false;
    const uint32_t now_us = micros();
    const int32_t before[] = {left.ticks, right.ticks};
    read(0, bytes);
    read(1, bytes + BLOCK_BYTES);
    const float dt = (now_us - measured_us_) * 1e-6f;
    measured_us_ = now_us;
    if (is_known_) addWay(left.ticks - before[0], right.ticks - before[1], dt);
    is_known_ = true;
    return true;
  }

 private:
  static constexpr uint8_t LEFT_ID = 1, RIGHT_ID = 2;
  static const uint8_t IDS[2];
  static const int32_t LIMIT = 265;       // units: the largest speed that a new XL430 accepts, 0.21 m/s
  static const uint8_t WATCHDOG = 25;     // units of 20 ms: the servos stop when this program stops
  // The part of the control table from the torque to the temperature.
  static const uint16_t BLOCK_BYTES = dynamixel::PRESENT_TEMPERATURE + 1 - dynamixel::TORQUE_ENABLE;

  Wheel& wheel(uint8_t index) { return index == 0 ? left : right; }

  bool note(dynamixel::Result result) {
    if (result != dynamixel::DONE) ++failures;
    return result == dynamixel::DONE;
  }

  static int32_t toUnits(float wheel_speed) {
    const float units = wheel_speed / WHEEL_RADIUS / dynamixel::RADIANS_PER_SECOND;
    return static_cast<int32_t>(constrain(round(units), -LIMIT, LIMIT));
  }

  // Sets up a servo. The torque comes last: a servo without torque is set up again.
  void prepare(uint8_t id) {
    uint8_t mode;
    if (!note(bus_.read(id, dynamixel::OPERATING_MODE, &mode, 1))) return;
    if (mode != dynamixel::VELOCITY_MODE) {
      if (!release(id)) return;
      if (!note(bus_.write(id, dynamixel::OPERATING_MODE, dynamixel::VELOCITY_MODE, 1))) return;
    }
    if (!note(bus_.write(id, dynamixel::BUS_WATCHDOG, 0, 1))) return;  // clears its alarm
    if (!note(bus_.write(id, dynamixel::BUS_WATCHDOG, WATCHDOG, 1))) return;
    note(bus_.write(id, dynamixel::TORQUE_ENABLE, 1, 1));
  }
  bool release(uint8_t id) { return note(bus_.write(id, dynamixel::TORQUE_ENABLE, 0, 1)); }

  void read(uint8_t index, const uint8_t* bytes) {
    Wheel& wheel = this->wheel(index);
    const uint8_t* block = bytes - dynamixel::TORQUE_ENABLE;
    const bool has_alarm = static_cast<int8_t>(block[dynamixel::BUS_WATCHDOG]) < 0;
    wheel.has_torque = block[dynamixel::TORQUE_ENABLE];
    wheel.hardware_error = block[dynamixel::HARDWARE_ERROR_STATUS];
    wheel.load = dynamixel::toInt16(block + dynamixel::PRESENT_LOAD) * 0.001f;
    wheel.speed = dynamixel::toInt32(block + dynamixel::PRESENT_VELOCITY) * dynamixel::RADIANS_PER_SECOND;
    wheel.ticks = dynamixel::toInt32(block + dynamixel::PRESENT_POSITION);
    wheel.volts = dynamixel::toInt16(block + dynamixel::PRESENT_INPUT_VOLTAGE) * 0.1f;
    wheel.celsius = block[dynamixel::PRESENT_TEMPERATURE];
    // The power of the servo was off for a moment, so it has lost its count of turns.
    const bool has_restarted = block[dynamixel::BUS_WATCHDOG] == 0;
    if (has_restarted) is_known_ = false;
    if (!wants_torque_) {
      if (wheel.has_torque) release(IDS[index]);
      if (has_restarted) note(bus_.write(IDS[index], dynamixel::BUS_WATCHDOG, WATCHDOG, 1));
    } else if ((!wheel.has_torque || has_alarm || has_restarted) && !wheel.hardware_error) {
      prepare(IDS[index]);
    }
  }

  void addWay(int32_t left_ticks, int32_t right_ticks, float dt) {
    const float left_angle = left_ticks * dynamixel::RADIANS_PER_TICK;
    const float right_angle = right_ticks * dynamixel::RADIANS_PER_TICK;
    left.angle += left_angle;
    right.angle += right_angle;
    const float way = (left_angle + right_angle) * (WHEEL_RADIUS / 2);
    const float turn = (right_angle - left_angle) * (WHEEL_RADIUS / WHEEL_SEPARATION);
    x += way * cos(heading + turn / 2);
    y += way * sin(heading + turn / 2);
    heading += turn;
    if (heading > PI) heading -= TWO_PI;
    if (heading < -PI) heading += TWO_PI;
    speed = way / dt;
    turn_rate = turn / dt;
  }

  DynamixelPort port_;
  dynamixel::Bus<DynamixelPort, 96> bus_;
  uint32_t measured_us_;
  bool is_known_;  // whether the next ticks continue the last ones
  bool wants_torque_;
};

const uint8_t Wheels::IDS[2] = {Wheels::LEFT_ID, Wheels::RIGHT_ID};

#endif

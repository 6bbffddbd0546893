// Two driven wheels: converts speeds to motor signals, and wheel angles to the robot's position.
#ifndef DRIVE_H
#define DRIVE_H

#include <Arduino.h>

// Uncomment this line if the wheels have encoders: left A on pin 2, right A on pin 3. Without
// encoders, the robot assumes that its motors turn exactly as fast as commanded.
// #define ENCODERS

// The values of a TurtleBot3 Burger.
const float WHEEL_RADIUS = 0.033;      // m
const float WHEEL_SEPARATION = 0.160;  // m
const float MAX_SPEED = 0.22;          // m/s
const float MAX_TURN_RATE = 2.84;      // rad/s
const float TICKS_PER_TURN = 4096;     // of an encoder

const unsigned long COMMAND_LIFE_MS = 500;  // after this time without a new command, the robot stops

struct Wheel {
  const uint8_t direction_pin;
  const uint8_t pwm_pin;
  volatile int32_t ticks;
  float target;  // rad/s
  float speed;   // rad/s
  float angle;   // rad
  float rest;    // the fraction of a tick, without an encoder
};

Wheel left = {4, 5, 0, 0, 0, 0, 0};
Wheel right = {7, 6, 0, 0, 0, 0, 0};

float x, y, heading;        // m, m, rad since the start or the last reset
float speed, turn_rate;     // m/s, rad/s
bool has_power = true;
unsigned long commanded_ms;

#if defined(ENCODERS)
void countLeft() { left.ticks += left.target < 0 ? -1 : 1; }
void countRight() { right.ticks += right.target < 0 ? -1 : 1; }
#endif

void beginDrive() {
  pinMode(left.direction_pin, OUTPUT);
  pinMode(left.pwm_pin, OUTPUT);
  pinMode(right.direction_pin, OUTPUT);
  pinMode(right.pwm_pin, OUTPUT);
#if defined(ENCODERS)
  attachInterrupt(digitalPinToInterrupt(2), countLeft, CHANGE);
  attachInterrupt(digitalPinToInterrupt(3), countRight, CHANGE);
#endif
}

void command(float forward, float turn) {
  forward = constrain(forward, -MAX_SPEED, MAX_SPEED);
  turn = constrain(turn, -MAX_TURN_RATE, MAX_TURN_RATE);
  left.target = (forward - turn * WHEEL_SEPARATION / 2) / WHEEL_RADIUS;
  right.target = (forward + turn * WHEEL_SEPARATION / 2) / WHEEL_RADIUS;
  commanded_ms = millis();
}

void turnWheel(Wheel& wheel, float dt) {
  if (!has_power) wheel.target = 0;
  // The motor gets the whole supply voltage at full speed straight ahead.
  const float duty = fabs(wheel.target) * (255 * WHEEL_RADIUS / MAX_SPEED);
  digitalWrite(wheel.direction_pin, wheel.target < 0);
  analogWrite(wheel.pwm_pin, duty < 255 ? duty + 0.5 : 255);

  const float before = wheel.angle;
#if !defined(ENCODERS)
  wheel.rest += wheel.target * dt * (TICKS_PER_TURN / TWO_PI);
  const int32_t whole = wheel.rest;
  wheel.ticks += whole;
  wheel.rest -= whole;
#endif
  noInterrupts();
  const int32_t ticks = wheel.ticks;
  interrupts();
  wheel.angle = ticks * (TWO_PI / TICKS_PER_TURN);
  wheel.speed = (wheel.angle - before) / dt;
}

// Updates the motors and the position. Call it often; `dt` is the time since the last call, in seconds.
void drive(float dt) {
  if (millis() - commanded_ms > COMMAND_LIFE_MS) left.target = right.target = 0;
  turnWheel(left, dt);
  turnWheel(right, dt);

  speed = (left.speed + right.speed) * (WHEEL_RADIUS / 2);
  turn_rate = (right.speed - left.speed) * (WHEEL_RADIUS / WHEEL_SEPARATION);
  const float halfway = heading + turn_rate * dt / 2;
  x += speed * dt * cos(halfway);
  y += speed * dt * sin(halfway);
  heading += turn_rate * dt;
  if (heading > PI) heading -= TWO_PI;
  if (heading < -PI) heading += TWO_PI;
}

void resetOdometry() { x = y = heading = 0; }

#endif

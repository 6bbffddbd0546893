// The control table of DYNAMIXEL X servos: the part for wheels. Source: ROBOTIS e-Manual, XL430-W250.
#ifndef DYNAMIXEL_X_SERIES_H_
#define DYNAMIXEL_X_SERIES_H_

#include <stdint.h>

namespace dynamixel {

// Addresses, with the size in bytes.
const uint16_t OPERATING_MODE = 11;         // 1, kept without power; written only while the torque is off
const uint16_t VELOCITY_LIMIT = 44;         // 4, kept without power
const uint16_t TORQUE_ENABLE = 64;          // 1
const uint16_t HARDWARE_ERROR_STATUS = 70;  // 1, bits
const uint16_t BUS_WATCHDOG = 98;           // 1, units of 20 ms; the servo stops after this long without a packet
const uint16_t GOAL_VELOCITY = 104;         // 4
const uint16_t PROFILE_ACCELERATION = 108;  // 4
const uint16_t PRESENT_LOAD = 126;          // 2, units of 0.1 % of the full torque; on XM and XH servos the current
const uint16_t PRESENT_VELOCITY = 128;      // 4
const uint16_t PRESENT_POSITION = 132;      // 4
const uint16_t PRESENT_INPUT_VOLTAGE = 144;  // 2, units of 0.1 V
const uint16_t PRESENT_TEMPERATURE = 146;   // 1, degrees Celsius

const uint8_t VELOCITY_MODE = 1;
const uint16_t XL430_MODEL = 1060;

const float RADIANS_PER_TICK = 6.2831853f / 4096;            // of a position
const float RADIANS_PER_SECOND = 0.229f * 6.2831853f / 60;   // of a velocity: units of 0.229 turns a minute

}  // namespace dynamixel

#endif

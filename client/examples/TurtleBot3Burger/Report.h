// The state of the robot's parts for /diagnostics.
#ifndef REPORT_H
#define REPORT_H

#include <diagnostic_msgs/DiagnosticArray.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "Sensors.h"
#include "Wheels.h"

class Report {
 public:
  diagnostic_msgs::DiagnosticArray& make(const Wheels& wheels, const Sensors& sensors, bool has_imu) {
    text_bytes_ = 0;
    first_value_ = value_count_ = status_count_ = 0;
    add("IMU Sensor", "MPU9250", has_imu ? FINE : FAILURE, has_imu ? "measures" : "no MPU-9250 answers");

    addValue("left: supply", wheels.left.volts, "V");
    addValue("right: supply", wheels.right.volts, "V");
    addValue("left: temperature", wheels.left.celsius, "C");
    addValue("right: temperature", wheels.right.celsius, "C");
    addValue("left: load", wheels.left.load * 100, "%");
    addValue("right: load", wheels.right.load * 100, "%");
    addValue("failed requests", wheels.failures, "");
    addMotors(wheels);

    const float volts = sensors.batteryVolts();
    addValue("voltage", volts, "V");
    addValue("charge", sensors.batteryPart() * 100, "%");
    add("Power System", "Battery", volts < EMPTY_VOLTS ? WARNING : FINE, volts < EMPTY_VOLTS ? "charge it" : "charged");

    add("Analog Button", "OpenCR Button", FINE, sensors.buttons() ? "pushed" : "not pushed");
    array_.status = statuses_;
    array_.status_length = status_count_;
    return array_;
  }
  std_msgs::Header& header() { return array_.header; }

 private:
  typedef diagnostic_msgs::DiagnosticStatus Status;
  // The levels of DiagnosticStatus. OK is a macro of the board's core.
  static const uint8_t FINE = 0, WARNING = 1, FAILURE = 2;

  void addMotors(const Wheels& wheels) {
    if (wheels.has_failed) {
      add("Actuator", "DYNAMIXEL X", FAILURE, "a servo does not answer");
    } else if (wheels.left.hardware_error || wheels.right.hardware_error) {
      const char* message = wheels.left.hardware_error ? "the left servo has a hardware error: 0x%02x"
                                                       : "the right servo has a hardware error: 0x%02x";
      add("Actuator", "DYNAMIXEL X", FAILURE,
          print(message, wheels.left.hardware_error ? wheels.left.hardware_error : wheels.right.hardware_error));
    } else {
      add("Actuator", "DYNAMIXEL X", FINE, wheels.hasTorque() ? "torque on" : "torque off");
    }
  }

  // Adds a status with the values that were added since the last status.
  void add(const char* name, const char* hardware, uint8_t level, const char* message) {
    Status& status = statuses_[status_count_++];
    status.name = name;
    status.hardware_id = hardware;
    status.level = level;
    status.message = message;
    status.values_length = value_count_ - first_value_;
    status.values = values_ + first_value_;
    first_value_ = value_count_;
  }
  // Writes a value with one decimal, without %f: not every board's printf supports it.
  void addValue(const char* key, float value, const char* unit) {
    const long tenths = lround(value * 10);
    values_[value_count_].key = key;
    values_[value_count_++].value = print("%s%ld.%ld %s", tenths < 0 ? "-" : "", labs(tenths) / 10, labs(tenths) % 10, unit);
  }
  const char* print(const char* format, ...) {
    char* text = texts_ + text_bytes_;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof texts_ - text_bytes_, format, arguments);
    va_end(arguments);
    text_bytes_ += strlen(text) + 1;
    return text;
  }

  static const uint8_t STATUSES = 4, VALUES = 9;
  diagnostic_msgs::DiagnosticArray array_;
  Status statuses_[STATUSES];
  diagnostic_msgs::KeyValue values_[VALUES];
  char texts_[256];
  size_t text_bytes_;
  uint8_t first_value_, value_count_, status_count_;
};

#endif

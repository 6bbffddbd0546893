// An MPU-9150 on I2C: accelerometer, gyroscope, and (as a separate chip in the same case) magnetometer.
#ifndef MPU9150_H
#define MPU9150_H

#include <Arduino.h>
#include <Wire.h>

struct Vector3 {
  float x, y, z;
};

class Mpu9150 {
 public:
  Vector3 acceleration;      // m/s^2; if the sensor is level and at rest, z is 9.81, the reaction to gravity
  Vector3 angular_velocity;  // rad/s
  Vector3 magnetic_field;    // tesla

  // Returns false if no sensor answers. Keep the sensor still: the gyroscope's current values become its zero.
  bool begin() {
    Wire.begin();
    Wire.setClock(400000);
    if (!write(MPU, 0x6b, 0x01)) return false;  // wake up
    write(MPU, 0x1a, 3);                        // filter: 44 Hz
    write(MPU, 0x1b, 1 << 3);                   // gyroscope up to 500 degrees a second
    write(MPU, 0x1c, 1 << 3);                   // accelerometer up to 4 g
    write(MPU, 0x37, 0x02);                     // access the magnetometer directly
    write(MAGNETOMETER, 0x0a, 0x0f);            // access its factory calibration first
    if (read(MAGNETOMETER, 0x10, 3)) {
      for (int i = 0; i < 3; i++) adjustment_[i] = 1 + (Wire.read() - 128) / 256.0;
    }
    write(MAGNETOMETER, 0x0a, 0);
    measureMagneticField();
    delay(50);
    findZero();
    return true;
  }

  void measure() {
    if (read(MPU, 0x3b, 14)) {
      acceleration = readVector(4 * 9.80665 / 32768);
      readWord();  // its temperature
      angular_velocity = readVector(500 * DEG_TO_RAD / 32768);
      angular_velocity.x -= zero_.x;
      angular_velocity.y -= zero_.y;
      angular_velocity.z -= zero_.z;
    }
    measureMagneticField();
  }

 private:
  static const uint8_t MPU = 0x68;
  static const uint8_t MAGNETOMETER = 0x0c;

  // A measurement takes 9 ms: if the last one is ready, reads it and starts the next one.
  void measureMagneticField() {
    if (read(MAGNETOMETER, 0x02, 1) && (Wire.read() & 1) && read(MAGNETOMETER, 0x03, 6)) {
      // The magnetometer's axes differ: its x is the case's y, its y is the case's x, and its z points down.
      const float tesla = 0.3e-6;
      magnetic_field.y = readLittleWord() * tesla * adjustment_[0];
      magnetic_field.x = readLittleWord() * tesla * adjustment_[1];
      magnetic_field.z = -readLittleWord() * tesla * adjustment_[2];
      ordered_ = false;
    }
    if (!ordered_) ordered_ = write(MAGNETOMETER, 0x0a, 1);
  }

  void findZero() {
    const int samples = 32;
    Vector3 sum = {0, 0, 0};
    for (int i = 0; i < samples; i++) {
      measure();
      sum.x += angular_velocity.x;
      sum.y += angular_velocity.y;
      sum.z += angular_velocity.z;
      delay(2);
    }
    const Vector3 mean = {sum.x / samples, sum.y / samples, sum.z / samples};
    // According to the data sheet, the offset is less than 20 degrees a second: more is a movement.
    const float limit = 20 * DEG_TO_RAD;
    if (fabs(mean.x) < limit && fabs(mean.y) < limit && fabs(mean.z) < limit) zero_ = mean;
  }

  bool write(uint8_t chip, uint8_t place, uint8_t value) {
    Wire.beginTransmission(chip);
    Wire.write(place);
    Wire.write(value);
    return Wire.endTransmission() == 0;
  }

  bool read(uint8_t chip, uint8_t place, uint8_t count) {
    Wire.beginTransmission(chip);
    Wire.write(place);
    return Wire.endTransmission(false) == 0 && Wire.requestFrom(chip, count) == count;
  }

  int16_t readWord() {
    const uint8_t high = Wire.read();
    return high << 8 | Wire.read();
  }
  int16_t readLittleWord() {
    const uint8_t low = Wire.read();
    return low | Wire.read() << 8;
  }
  Vector3 readVector(float unit) {
    Vector3 vector;
    vector.x = readWord() * unit;
    vector.y = readWord() * unit;
    vector.z = readWord() * unit;
    return vector;
  }

  Vector3 zero_ = {0, 0, 0};
  float adjustment_[3] = {1, 1, 1};
  bool ordered_ = false;
};

#endif

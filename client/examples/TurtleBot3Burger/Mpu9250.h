// The MPU-9250 of the OpenCR, on its own SPI: accelerometer, gyroscope and, behind it, the magnetometer AK8963.
#ifndef MPU9250_H
#define MPU9250_H

#include <Arduino.h>
#include <SPI.h>

struct Vector3 {
  float x, y, z;
};

// Axes: x forward, y left, z up.
class Mpu9250 {
 public:
  Vector3 acceleration;      // m/s^2; if the robot is level and at rest, z is 9.81, the reaction to gravity
  Vector3 angular_velocity;  // rad/s
  Vector3 magnetic_field;    // tesla

  // Returns false if no MPU-9250 answers.
  bool begin() {
    pinMode(BDPIN_SPI_CS_IMU, OUTPUT);
    digitalWrite(BDPIN_SPI_CS_IMU, HIGH);
    SPI_IMU.begin();
    SPI_IMU.setDataMode(SPI_MODE3);
    SPI_IMU.setBitOrder(MSBFIRST);
    SPI_IMU.setClockDivider(SPI_CLOCK_DIV128);
    write(0x6b, 0x80);  // reset
    delay(100);
    uint8_t name;
    read(0x75, &name, 1);
    if (name != 0x71) return false;
    write(0x6b, 0x01);   // wake up
    write(0x6a, 0x30);   // only SPI to the board; the chip controls the magnetometer's I2C
    write(0x24, 0x0d);   // at 400 kHz
    write(0x19, 4);      // 200 measurements a second
    write(0x1a, 3);      // filters: 41 Hz
    write(0x1d, 3);
    write(0x1b, 1 << 3); // gyroscope up to 500 degrees a second
    write(0x1c, 0);      // accelerometer up to 2 g
    if (beginMagnetometer()) readMagnetometerAlways();
    SPI_IMU.setClockDivider(SPI_CLOCK_DIV8);
    calibrate();
    return true;
  }

  // Starts to compute the gyroscope's zero, the mean of its next measurements. The robot must be at rest.
  void calibrate() {
    samples_ = 0;
    sum_.x = sum_.y = sum_.z = 0;
  }
  bool isCalibrated() const { return samples_ == SAMPLES; }

  void measure() {
    uint8_t bytes[22];
    read(0x3b, bytes, sizeof bytes);
    acceleration = vector(bytes, 2 * 9.80665f / 32768);
    angular_velocity = vector(bytes + 8, 500 * PI / 180 / 32768);
    if (!isCalibrated()) addSample();
    angular_velocity.x -= zero_.x;
    angular_velocity.y -= zero_.y;
    angular_velocity.z -= zero_.z;
    const uint8_t* field = bytes + 14;
    const bool is_new = field[0] & 1, is_too_strong = field[7] & 8;
    if (!is_new || is_too_strong) return;
    // The magnetometer has other axes than the chip.
    const float tesla = 0.15e-6f;
    magnetic_field.x = littleWord(field + 3) * tesla * adjustment_[1];
    magnetic_field.y = littleWord(field + 1) * tesla * adjustment_[0];
    magnetic_field.z = -littleWord(field + 5) * tesla * adjustment_[2];
  }

 private:
  static const uint8_t MAGNETOMETER = 0x0c;
  static const uint16_t SAMPLES = 200;  // a second

  void addSample() {
    sum_.x += angular_velocity.x;
    sum_.y += angular_velocity.y;
    sum_.z += angular_velocity.z;
    if (++samples_ < SAMPLES) return;
    zero_.x = sum_.x / SAMPLES;
    zero_.y = sum_.y / SAMPLES;
    zero_.z = sum_.z / SAMPLES;
  }

  bool beginMagnetometer() {
    uint8_t factory[3];
    if (!writeMagnetometer(0x0b, 1)) return false;     // reset
    if (!writeMagnetometer(0x0a, 0x0f)) return false;  // access its factory calibration
    for (uint8_t i = 0; i < 3; ++i) {
      if (!readMagnetometer(0x10 + i, factory[i])) return false;
      adjustment_[i] = 1 + (factory[i] - 128) / 256.0f;
    }
    return writeMagnetometer(0x0a, 0) && writeMagnetometer(0x0a, 0x16);  // 100 measurements a second, of 16 bits
  }

  // Makes the chip read 8 bytes of the magnetometer, starting with its status, at each measurement.
  void readMagnetometerAlways() {
    write(0x25, 0x80 | MAGNETOMETER);
    write(0x26, 0x02);
    write(0x27, 0x88);
  }

  bool writeMagnetometer(uint8_t address, uint8_t value) {
    write(0x31, MAGNETOMETER);
    write(0x32, address);
    write(0x33, value);
    return transferOnce();
  }
  bool readMagnetometer(uint8_t address, uint8_t& value) {
    write(0x31, 0x80 | MAGNETOMETER);
    write(0x32, address);
    if (!transferOnce()) return false;
    read(0x35, &value, 1);
    return true;
  }
  bool transferOnce() {
    write(0x34, 0x80);
    for (uint8_t i = 0; i < 50; ++i) {
      delay(1);
      uint8_t status;
      read(0x36, &status, 1);
      if (status & 0x40) return !(status & 0x10);  // done; not acknowledged
    }
    return false;
  }

  void write(uint8_t address, uint8_t value) {
    digitalWrite(BDPIN_SPI_CS_IMU, LOW);
    SPI_IMU.transfer(address);
    SPI_IMU.transfer(value);
    digitalWrite(BDPIN_SPI_CS_IMU, HIGH);
  }
  void read(uint8_t address, uint8_t* bytes, uint8_t count) {
    digitalWrite(BDPIN_SPI_CS_IMU, LOW);
    SPI_IMU.transfer(address | 0x80);
    for (uint8_t i = 0; i < count; ++i) bytes[i] = SPI_IMU.transfer(0);
    digitalWrite(BDPIN_SPI_CS_IMU, HIGH);
  }

  static int16_t littleWord(const uint8_t* bytes) { return static_cast<int16_t>(bytes[0] | bytes[1] << 8); }
  static int16_t bigWord(const uint8_t* bytes) { return static_cast<int16_t>(bytes[0] << 8 | bytes[1]); }
  static Vector3 vector(const uint8_t* bytes, float unit) {
    const Vector3 vector = {bigWord(bytes) * unit, bigWord(bytes + 2) * unit, bigWord(bytes + 4) * unit};
    return vector;
  }

  uint16_t samples_ = 0;
  Vector3 sum_ = {0, 0, 0};
  Vector3 zero_ = {0, 0, 0};
  float adjustment_[3] = {1, 1, 1};
};

#endif

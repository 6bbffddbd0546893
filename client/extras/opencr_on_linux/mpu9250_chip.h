// A simulated MPU-9250 with its AK8963, as SPI accesses them: registers, ranges, the controller of the magnetometer's
// I2C. Not simulated: filters, noise, FIFO, self-test, interrupts, and the time that a transfer on I2C takes.
#ifndef MPU9250_CHIP_H_
#define MPU9250_CHIP_H_

#include <math.h>
#include <stdint.h>
#include <string.h>

class Mpu9250Chip {
 public:
  Mpu9250Chip() : rate_(), acceleration_(), field_() { reset(); }

  // Sets the values to measure: rad/s, m/s^2 and tesla, in the axes of the board (x forward, y left, z up).
  void setValues(const double (&rate)[3], const double (&acceleration)[3], const double (&field)[3]) {
    memcpy(rate_, rate, sizeof rate_);
    memcpy(acceleration_, acceleration, sizeof acceleration_);
    memcpy(field_, field, sizeof field_);
  }

  void select() { position_ = 0; }
  uint8_t transfer(uint8_t sent) {
    if (position_++ == 0) {
      address_ = sent & 0x7f;
      is_read_ = sent & 0x80;
      if (is_read_ && address_ <= EXT_SENS_DATA && EXT_SENS_DATA - address_ < 32) measure();
      return 0;
    }
    const uint8_t address = address_++ & 0x7f;
    if (is_read_) return registers_[address];
    write(address, sent);
    return 0;
  }

 private:
  static const uint8_t GYRO_CONFIG = 0x1b, ACCEL_CONFIG = 0x1c, SLV0 = 0x25, SLV4 = 0x31, MST_STATUS = 0x36;
  static const uint8_t ACCEL_OUT = 0x3b, EXT_SENS_DATA = 0x49, USER_CTRL = 0x6a, PWR_MGMT_1 = 0x6b, WHO_AM_I = 0x75;
  static const uint8_t MAGNETOMETER = 0x0c;

  void reset() {
    memset(registers_, 0, sizeof registers_);
    registers_[PWR_MGMT_1] = 0x01;
    registers_[WHO_AM_I] = 0x71;
    resetMagnetometer();
  }
  void resetMagnetometer() {
    memset(magnetometer_, 0, sizeof magnetometer_);
    magnetometer_[0] = 0x48;
    // The factory calibration: the factors 1.09, 1.1 and 1.05.
    magnetometer_[0x10] = 151;
    magnetometer_[0x11] = 154;
    magnetometer_[0x12] = 141;
  }

  void write(uint8_t address, uint8_t value) {
    if (address == PWR_MGMT_1 && value & 0x80) {
      reset();
    } else if (address == WHO_AM_I || (address >= MST_STATUS && address < EXT_SENS_DATA + 24)) {
      // Read only.
    } else {
      registers_[address] = value;
      if (address == SLV4 + 3 && value & 0x80) transferOnce();
    }
  }

  bool isMagnetometer(uint8_t address) const {
    return registers_[USER_CTRL] & 0x20 && (address & 0x7f) == MAGNETOMETER;
  }

  void transferOnce() {
    const uint8_t* slave = registers_ + SLV4;
    const uint8_t place = slave[1] & 0x1f;
    registers_[MST_STATUS] = 0x40;
    if (!isMagnetometer(slave[0])) {
      registers_[MST_STATUS] |= 0x10;
    } else if (slave[0] & 0x80) {
      registers_[SLV4 + 4] = magnetometer_[place];
    } else if (place == 0x0b && slave[2] & 1) {
      resetMagnetometer();
    } else if (place == 0x0a || place == 0x0c) {
      magnetometer_[place] = slave[2];
    }
  }

  void measure() {
    if (registers_[PWR_MGMT_1] & 0x40) return;  // the chip sleeps
    const double g_range = 2 << (registers_[ACCEL_CONFIG] >> 3 & 3);
    const double rate_range = 250 << (registers_[GYRO_CONFIG] >> 3 & 3);
    for (int i = 0; i < 3; ++i) {
      putBig(ACCEL_OUT + 2 * i, acceleration_[i] / 9.80665 / g_range * 32768);
      putBig(ACCEL_OUT + 8 + 2 * i, rate_[i] * 57.29577951308232 / rate_range * 32768);
    }
    putBig(ACCEL_OUT + 6, (25 - 21) * 333.87);  // 25 degrees Celsius
    measureField();
    const uint8_t* slave = registers_ + SLV0;
    const uint8_t count = slave[2] & 0x0f;
    if (!(slave[2] & 0x80) || !(slave[0] & 0x80) || !isMagnetometer(slave[0])) return;
    for (uint8_t i = 0; i < count; ++i) registers_[EXT_SENS_DATA + i] = magnetometer_[(slave[1] + i) & 0x1f];
  }

  void measureField() {
    const uint8_t mode = magnetometer_[0x0a] & 0x0f;
    if (mode == 0 || mode == 0x0f) return;
    const double tesla = magnetometer_[0x0a] & 0x10 ? 0.15e-6 : 0.6e-6;
    const double own[] = {field_[1], field_[0], -field_[2]};
    for (int i = 0; i < 3; ++i) {
      const int16_t word = toWord(own[i] / tesla / (1 + (magnetometer_[0x10 + i] - 128) / 256.0));
      magnetometer_[3 + 2 * i] = static_cast<uint8_t>(word);
      magnetometer_[4 + 2 * i] = static_cast<uint8_t>(word >> 8);
    }
    magnetometer_[2] = 0x01;
    magnetometer_[9] = magnetometer_[0x0a] & 0x10;
  }

  static int16_t toWord(double value) {
    return static_cast<int16_t>(lround(value < -32768 ? -32768 : value > 32767 ? 32767 : value));
  }
  void putBig(int address, double value) {
    const int16_t word = toWord(value);
    registers_[address] = static_cast<uint8_t>(word >> 8);
    registers_[address + 1] = static_cast<uint8_t>(word);
  }

  double rate_[3], acceleration_[3], field_[3];
  uint8_t registers_[128];
  uint8_t magnetometer_[32];
  size_t position_;
  uint8_t address_;
  bool is_read_;
};

#endif

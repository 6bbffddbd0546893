/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * An MPU-9150 at 0x68: accelerometer, gyroscope and thermometer, with the registers of the MPU-6050. Not modeled: the
 * DMP, the FIFO, its I2C master (the magnetometer needs bypass mode), self test, noise and offsets.
 */
#include <math.h>
#include <string.h>

#include "board.h"

#define GYRO_CONFIG 0x1b
#define ACCEL_CONFIG 0x1c
#define INT_PIN_CFG 0x37
#define INT_STATUS 0x3a
#define ACCEL_XOUT_H 0x3b
#define SENSOR_BYTES 14
#define USER_CTRL 0x6a
#define PWR_MGMT_1 0x6b
#define WHO_AM_I 0x75
#define DEVICE_RESET 0x80
#define SLEEP 0x40
#define BYPASS 0x02
#define OWN_MASTER 0x20
#define REGISTERS 0x80

#define ACCEL_LSB_PER_G 16384.0
#define GYRO_LSB_PER_DPS 131.0
/* 25 °C: (25 - 35) * 340 */
#define TEMPERATURE_LSB (-3400)

static uint8_t registers[REGISTERS];
static uint8_t at;
static bool expects_address;

void mpu9150_power_up(void) {
    memset(registers, 0, sizeof registers);
    registers[PWR_MGMT_1] = SLEEP;
    registers[WHO_AM_I] = 0x68;
    at = 0;
}

bool mpu9150_bypass(void) { return registers[INT_PIN_CFG] & BYPASS && !(registers[USER_CTRL] & OWN_MASTER); }

static bool answers(void) { return true; }

static void begin(void) { expects_address = true; }

static void put_word(int place, double value) {
    long rounded = lround(value);
    int16_t word = (int16_t)(rounded > 32767 ? 32767 : rounded < -32768 ? -32768 : rounded);
    registers[place] = (uint8_t)((uint16_t)word >> 8);
    registers[place + 1] = (uint8_t)word;
}

/* The values change only at the start of a burst read; during sleep they keep their last values, 0 at first. */
static void measure(void) {
    struct vector gravity, turn_rate, field;
    if (registers[PWR_MGMT_1] & SLEEP) return;
    attitude_measure(&gravity, &turn_rate, &field);
    double accel = ACCEL_LSB_PER_G / (1 << (registers[ACCEL_CONFIG] >> 3 & 3));
    double gyro = GYRO_LSB_PER_DPS / (1 << (registers[GYRO_CONFIG] >> 3 & 3));
    put_word(ACCEL_XOUT_H, gravity.x * accel);
    put_word(ACCEL_XOUT_H + 2, gravity.y * accel);
    put_word(ACCEL_XOUT_H + 4, gravity.z * accel);
    put_word(ACCEL_XOUT_H + 6, TEMPERATURE_LSB);
    put_word(ACCEL_XOUT_H + 8, turn_rate.x * gyro);
    put_word(ACCEL_XOUT_H + 10, turn_rate.y * gyro);
    put_word(ACCEL_XOUT_H + 12, turn_rate.z * gyro);
}

static void write_byte(uint8_t byte) {
    if (expects_address) {
        expects_address = false;
        at = byte;
        measure();
        return;
    }
    bool read_only = at >= REGISTERS || at == WHO_AM_I || (at >= INT_STATUS && at < ACCEL_XOUT_H + SENSOR_BYTES);
    if (!read_only) registers[at] = byte;
    if (at == PWR_MGMT_1 && byte & DEVICE_RESET) mpu9150_power_up();
    at++;
}

static uint8_t read_byte(void) {
    if (at >= REGISTERS) return 0;
    if (at == INT_STATUS) registers[INT_STATUS] = registers[PWR_MGMT_1] & SLEEP ? 0 : 1;
    return registers[at++];
}

const struct twi_device mpu9150_device = {0x68, answers, begin, write_byte, read_byte};

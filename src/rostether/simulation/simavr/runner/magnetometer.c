/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The MPU-9150's magnetometer, an AK8975 at 0x0c, which answers only in the MPU's bypass mode. Its axes differ from
 * the MPU's: its x is the MPU's y, its y the MPU's x, and its z points down.
 */
#include <math.h>
#include <string.h>

#include "board.h"

#define WIA 0x00
#define INFO 0x01
#define ST1 0x02
#define HXL 0x03
#define ST2 0x09
#define CNTL 0x0a
#define ASAX 0x10
#define REGISTERS 0x13
#define DATA_READY 0x01
#define MODE_MASK 0x0f
#define POWER_DOWN 0x00
#define SINGLE_MEASUREMENT 0x01
#define FUSE_ROM 0x0f

#define UT_PER_LSB 0.3
#define LARGEST 4095
#define MEASUREMENT_US 7300
#define NO_ADJUSTMENT 128

static uint8_t registers[REGISTERS];
static uint8_t at;
static bool expects_address;
static cycles_t ready_at;

void magnetometer_power_up(void) {
    memset(registers, 0, sizeof registers);
    registers[WIA] = 0x48;
    ready_at = NEVER;
    at = 0;
}

static bool answers(void) { return mpu9150_bypass(); }

static void begin(void) { expects_address = true; }

static void put_word(int place, double field_ut) {
    long value = lround(field_ut / UT_PER_LSB);
    int16_t word = (int16_t)(value > LARGEST ? LARGEST : value < -LARGEST ? -LARGEST : value);
    registers[place] = (uint8_t)word;
    registers[place + 1] = (uint8_t)((uint16_t)word >> 8);
}

static void finish_measurement(void) {
    struct vector gravity, turn_rate, field;
    if (board.avr->cycle < ready_at) return;
    ready_at = NEVER;
    attitude_measure(&gravity, &turn_rate, &field);
    put_word(HXL, field.y);
    put_word(HXL + 2, field.x);
    put_word(HXL + 4, -field.z);
    registers[ST1] = DATA_READY;
    registers[CNTL] = POWER_DOWN;
}

static void write_byte(uint8_t byte) {
    finish_measurement();
    if (expects_address) {
        expects_address = false;
        at = byte;
        return;
    }
    if (at == CNTL) {
        registers[CNTL] = byte & MODE_MASK;
        bool measures = registers[CNTL] == SINGLE_MEASUREMENT;
        ready_at = measures ? board.avr->cycle + MEASUREMENT_US * CYCLES_PER_US : NEVER;
    }
    at++;
}

static uint8_t read_byte(void) {
    finish_measurement();
    if (at >= REGISTERS) return 0;
    uint8_t value = registers[at];
    if (at >= ASAX) value = registers[CNTL] == FUSE_ROM ? NO_ADJUSTMENT : 0;
    if (at >= HXL && at <= ST2) registers[ST1] = 0;
    at++;
    return value;
}

const struct twi_device magnetometer_device = {0x0c, answers, begin, write_byte, read_byte};

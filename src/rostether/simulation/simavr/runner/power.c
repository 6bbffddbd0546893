/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Power and resets. After power-up, RAM and registers have noise, which depends on the seed. A reset keeps the RAM.
 * There is no bootloader: the sketch starts immediately, with the watchdog off as after a bootloader.
 */
#include <stdlib.h>
#include <string.h>

#include "board.h"

static uint64_t noise = 1;

void power_seed(uint64_t seed) { noise = seed * 2 + 1; }

static uint8_t next_noise(void) {
    noise ^= noise << 13;
    noise ^= noise >> 7;
    noise ^= noise << 17;
    return (uint8_t)(noise >> 32);
}

static void restart(const char *cause, avr_regbit_t flag) {
    avr_t *avr = board.avr;
    size_t size = (size_t)avr->ramend + 1;
    uint8_t *kept = malloc(size);
    if (!kept) abort();
    memcpy(kept, avr->data, size);
    avr_reset(avr);
    memcpy(avr->data, kept, 32);
    memcpy(avr->data + avr->ioend + 1, kept + avr->ioend + 1, size - avr->ioend - 1);
    free(kept);
    if (flag.reg) avr->data[flag.reg] |= (uint8_t)(flag.mask << flag.bit);
    core_reset();
    uart_reset();
    pins_reset();
    sonar_reset();
    network_reset();
    w5100_reset();
    event_begin("reset");
    event_text("cause", cause);
    event_end();
}

void power_reset(const char *cause) {
    avr_t *avr = board.avr;
    if (!board.powered) return;
    restart(cause, strcmp(cause, "watchdog") == 0 ? avr->reset_flags.wdrf : avr->reset_flags.extrf);
}

void power_on(const char *cause) {
    avr_t *avr = board.avr;
    board.powered = true;
    for (int i = 0; i < 32; i++) avr->data[i] = next_noise();
    for (int i = avr->ioend + 1; i <= avr->ramend; i++) avr->data[i] = next_noise();
    canaries_fill();
    mpu9150_power_up();
    magnetometer_power_up();
    link_power(true);
    restart(cause, avr->reset_flags.porf);
}

void power_off(void) {
    if (!board.powered) return;
    board.powered = false;
    avr_cycle_timer_reset(board.avr);
    memset(board.avr->data + 32, 0, board.avr->ioend - 31);
    uart_reset();
    pins_reset();
    network_reset();
    link_power(false);
    event_begin("power");
    event_bool("on", false);
    event_end();
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The effect of timers on pins: PWM, read from the timers' registers. The simulator computes compare matches and
 * overflows, but lacks some modes that count up and down, such as Arduino's mode for timers 1 and 2. Here they become
 * modes that only count up: their period is correct, but not the phase of their interrupts.
 */
#include <math.h>
#include <string.h>

#include <avr_ioport.h>
#include <avr_timer.h>

#include "board.h"

enum slope { NO_PWM, UP, UP_AND_DOWN };
enum top { FIXED, OCRA, ICR };

struct waveform {
    uint8_t slope, top, bits;
};

/* The modes by their number, WGM3..0; all chips of these boards have the same. */
static const struct waveform wide[16] = {
    {NO_PWM, FIXED, 16},     {UP_AND_DOWN, FIXED, 8}, {UP_AND_DOWN, FIXED, 9}, {UP_AND_DOWN, FIXED, 10},
    {NO_PWM, OCRA, 0},       {UP, FIXED, 8},          {UP, FIXED, 9},          {UP, FIXED, 10},
    {UP_AND_DOWN, ICR, 0},   {UP_AND_DOWN, OCRA, 0},  {UP_AND_DOWN, ICR, 0},   {UP_AND_DOWN, OCRA, 0},
    {NO_PWM, ICR, 0},        {NO_PWM, FIXED, 16},     {UP, ICR, 0},            {UP, OCRA, 0},
};
static const struct waveform narrow[8] = {
    {NO_PWM, FIXED, 8}, {UP_AND_DOWN, FIXED, 8}, {NO_PWM, OCRA, 0}, {UP, FIXED, 8},
    {NO_PWM, FIXED, 8}, {UP_AND_DOWN, OCRA, 0},  {NO_PWM, FIXED, 8}, {UP, OCRA, 0},
};

static unsigned read_wide(avr_io_addr_t low, avr_io_addr_t high) {
    const uint8_t *data = board.avr->data;
    return data[low] | (high ? data[high] << 8 : 0);
}

static double top_of(const avr_timer_t *timer, struct waveform waveform) {
    if (waveform.top == OCRA) return read_wide(timer->comp[0].r_ocr, timer->comp[0].r_ocrh);
    if (waveform.top == ICR) return read_wide(timer->r_icr, timer->r_icrh);
    return (1 << waveform.bits) - 1;
}

static struct pwm pwm_of(const avr_timer_t *timer, const avr_timer_comp_t *channel) {
    struct pwm result = {false, 0, 0};
    avr_t *avr = board.avr;
    uint8_t output = avr_regbit_get(avr, channel->com);
    uint8_t mode = avr_regbit_get_array(avr, (avr_regbit_t *)timer->wgm, 4);
    unsigned clock = avr_regbit_get_array(avr, (avr_regbit_t *)timer->cs, ARRAY_SIZE(timer->cs));
    struct waveform waveform = timer->r_tcnth ? wide[mode & 15] : narrow[mode & 7];
    if (output < avr_timer_com_clear || !clock || waveform.slope == NO_PWM) return result;
    double top = top_of(timer, waveform), compare = read_wide(channel->r_ocr, channel->r_ocrh);
    double ticks = waveform.slope == UP ? top + 1 : 2 * top;
    double high = waveform.slope == UP ? compare + 1 : 2 * compare;
    result.active = true;
    result.duty = ticks > 0 ? fmin(high / ticks, 1.0) : 0.0;
    if (output == avr_timer_com_set) result.duty = 1.0 - result.duty;
    result.period_us = ticks * (double)(1u << timer->cs_div[clock]) / CYCLES_PER_US;
    return result;
}

/* Returns the number of channels on a pin (some pins of a Mega have two); `active` gets the active channel's PWM. */
static int find_channels(const struct pin_place *place, struct pwm *active) {
    int count = 0;
    if (place->bit < 0) return 0;
    const avr_irq_t *pin = avr_io_getirq(board.avr, AVR_IOCTL_IOPORT_GETIRQ(place->port), place->bit);
    for (avr_io_t *io = board.avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "timer") != 0) continue;
        const avr_timer_t *timer = (const avr_timer_t *)io;
        for (int i = 0; i < AVR_TIMER_COMP_COUNT; i++) {
            avr_ioport_getirq_t wire = {.bit = timer->comp[i].com_pin};
            if (!wire.bit.reg || avr_ioctl(board.avr, AVR_IOCTL_IOPORT_GETIRQ_REGBIT, &wire) < 1) continue;
            if (wire.irq[0] != pin) continue;
            struct pwm pwm = pwm_of(timer, &timer->comp[i]);
            if (pwm.active) *active = pwm;
            count++;
        }
    }
    return count;
}

bool timers_drive(const struct pin_place *place) {
    struct pwm unused;
    return find_channels(place, &unused) > 0;
}

struct pwm timers_pwm(const struct pin_place *place) {
    struct pwm active = {false, 0, 0};
    find_channels(place, &active);
    return active;
}

void timers_start(void) {
    for (avr_io_t *io = board.avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "timer") != 0) continue;
        avr_timer_t *timer = (avr_timer_t *)io;
        const struct waveform *waveforms = timer->r_tcnth ? wide : narrow;
        for (int mode = 0; mode < (timer->r_tcnth ? 16 : 8); mode++) {
            avr_timer_wgm_t *known = &timer->wgm_op[mode];
            if (waveforms[mode].slope != UP_AND_DOWN || known->kind == avr_timer_wgm_pwm) continue;
            *known = (avr_timer_wgm_t){0};
            known->kind = waveforms[mode].top == FIXED ? avr_timer_wgm_normal : avr_timer_wgm_pwm;
            /* One bit more, because counting up and down takes twice as long. */
            known->size = waveforms[mode].top == FIXED ? waveforms[mode].bits + 1u : 0;
            known->top = waveforms[mode].top == OCRA ? avr_timer_wgm_reg_ocra : avr_timer_wgm_reg_icr;
        }
    }
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * An HC-SR04: after a trigger pulse of at least 10 µs, it sends an echo pulse for as long as sound travels to the
 * obstacle and back. It sends no echo if the obstacle is nearer than 2 cm, farther than 4 m, or missing.
 *
 * The speed of sound is 342 m/s here, as in air of 18 °C. Sketches that calculate with 343 m/s (58.3 µs a
 * centimeter) are then accurate to a centimeter up to 3.4 m, with micros() and with pulseIn(). pulseIn() loses half
 * a percent to the timer's interrupts, as on a real board.
 */
#include "board.h"

#define SPEED_OF_SOUND 342.0
#define SHORTEST_TRIGGER_US 9 /* 10 minus the tolerance of delayMicroseconds */
#define BURST_US 460 /* from the trigger's end to the rising echo, as measured on modules */
#define NEAREST 0.02
#define FARTHEST 4.0

static struct pin *trig, *echo;
static double range = -1;
static cycles_t trigger_rose;

static cycles_t on_echo_end(avr_t *avr, cycles_t when, void *param) {
    (void)avr, (void)when, (void)param;
    pin_drive(echo, false);
    return 0;
}

static cycles_t on_echo(avr_t *avr, cycles_t when, void *param) {
    (void)when, (void)param;
    pin_drive(echo, true);
    avr_cycle_timer_register(avr, (cycles_t)(2 * range / SPEED_OF_SOUND * CLOCK_HZ + 0.5), on_echo_end, NULL);
    return 0;
}

static void on_trigger(struct pin *pin, bool level) {
    avr_t *avr = board.avr;
    (void)pin;
    if (level) {
        trigger_rose = avr->cycle;
        return;
    }
    bool busy = avr_cycle_timer_status(avr, on_echo, NULL) || avr_cycle_timer_status(avr, on_echo_end, NULL);
    if (busy || !board.powered || avr->cycle - trigger_rose < SHORTEST_TRIGGER_US * CYCLES_PER_US) return;
    if (range >= NEAREST && range <= FARTHEST) avr_cycle_timer_register(avr, BURST_US * CYCLES_PER_US, on_echo, NULL);
}

bool sonar_is_wired(void) { return trig != NULL; }

void sonar_wire(struct pin *new_trig, struct pin *new_echo) {
    if (trig) {
        avr_cycle_timer_cancel(board.avr, on_echo, NULL);
        avr_cycle_timer_cancel(board.avr, on_echo_end, NULL);
        pin_ignore(trig, on_trigger);
        pin_release(echo);
    }
    trig = new_trig;
    echo = new_echo;
    pin_listen(trig, on_trigger);
    pin_drive(echo, false);
}

void sonar_set_range(double meters) { range = meters; }

/* The simulator's reset has already canceled the echo's timers. */
void sonar_reset(void) {
    if (echo) pin_drive(echo, false);
}

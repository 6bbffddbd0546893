/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Pulses: PWM from the settings of the timers, and servo pulses by software or by a timer, on any pin.
 * The angle of a servo is that of Arduino's library: 544 µs is 0 degrees, 2400 µs is 180.
 */
#include <math.h>

#include "board.h"

#define MAX_WATCHED 16
#define LONGEST_SERVO_PULSE_US 3000.0
#define SHORTEST_SERVO_PULSE_US 300.0
/* Nearly the difference of one degree (10 or 11 µs). Interrupts delay the edges of software pulses by about half of
   that, which is not a new angle. */
#define NEW_ANGLE_US 9.5
#define ZERO_DEGREES_US 544.0
#define US_PER_DEGREE ((2400.0 - 544.0) / 180.0)

struct servo {
    struct pin *pin;
    cycles_t rose;
    double pulse_us, reported_us;
};

static struct servo servos[MAX_WATCHED];
static struct {
    struct pin *pin;
    struct pwm reported;
} watched[MAX_WATCHED];

const char *pulses_watch_pwm(struct pin *pin, bool on) {
    if (on && !timers_drive(pin_place(pin))) return NULL;
    int place = -1;
    for (int i = MAX_WATCHED; i-- > 0;)
        if (watched[i].pin == pin)
            place = i;
        else if (!watched[i].pin && (place < 0 || watched[place].pin != pin))
            place = i;
    if (place < 0) return on ? "too many pins are watched; unwatch one" : NULL;
    watched[place].pin = on ? pin : NULL;
    watched[place].reported = (struct pwm){0};
    return NULL;
}

static void report_pwm(const struct pin *pin, struct pwm pwm) {
    event_begin("pwm");
    event_text("pin", pin_name(pin));
    if (pwm.active) {
        event_number("duty", pwm.duty, 5);
        event_number("period_us", pwm.period_us, 3);
    } else {
        event_number("duty", pin_level(pin), 5);
    }
    event_bool("timer", pwm.active);
    event_end_droppable();
}

static struct servo *servo_on(const struct pin *pin) {
    for (int i = 0; i < MAX_WATCHED; i++)
        if (servos[i].pin == pin) return &servos[i];
    return NULL;
}

static void report_servo(struct servo *servo) {
    servo->reported_us = servo->pulse_us;
    event_begin("servo");
    event_text("pin", pin_name(servo->pin));
    event_number("pulse_us", servo->pulse_us, 3);
    event_number("angle_deg", (servo->pulse_us - ZERO_DEGREES_US) / US_PER_DEGREE, 3);
    event_end_droppable();
}

static void handle_pulse(struct servo *servo, double pulse_us) {
    if (pulse_us < SHORTEST_SERVO_PULSE_US || pulse_us > LONGEST_SERVO_PULSE_US) return;
    servo->pulse_us = pulse_us;
    if (fabs(pulse_us - servo->reported_us) >= NEW_ANGLE_US) report_servo(servo);
}

static void on_edge(struct pin *pin, bool level) {
    struct servo *servo = servo_on(pin);
    if (!servo || timers_pwm(pin_place(pin)).active) return;
    if (level)
        servo->rose = board.avr->cycle;
    else if (servo->rose)
        handle_pulse(servo, (double)(board.avr->cycle - servo->rose) / CYCLES_PER_US);
}

const char *pulses_watch_servo(struct pin *pin, bool on) {
    struct servo *servo = servo_on(pin);
    if (on && !servo) {
        servo = servo_on(NULL);
        if (!servo) return "too many servos are watched; unwatch one";
        *servo = (struct servo){.pin = pin};
        pin_listen(pin, on_edge);
    } else if (!on && servo) {
        pin_ignore(pin, on_edge);
        *servo = (struct servo){0};
    }
    return NULL;
}

bool pulses_report_servo(const struct pin *pin) {
    struct servo *servo = servo_on(pin);
    if (!servo) return false;
    report_servo(servo);
    return true;
}

/* Reports changes in the timers of watched pins, once in each slice. */
void pulses_update(void) {
    for (int i = 0; i < MAX_WATCHED; i++) {
        if (watched[i].pin) {
            struct pwm pwm = timers_pwm(pin_place(watched[i].pin));
            struct pwm *reported = &watched[i].reported;
            if (pwm.active != reported->active || fabs(pwm.duty - reported->duty) > 1e-6 ||
                fabs(pwm.period_us - reported->period_us) > 1e-3)
                report_pwm(watched[i].pin, *reported = pwm);
        }
        if (servos[i].pin) {
            struct pwm pwm = timers_pwm(pin_place(servos[i].pin));
            if (pwm.active && pwm.period_us > LONGEST_SERVO_PULSE_US) handle_pulse(&servos[i], pwm.duty * pwm.period_us);
        }
    }
}

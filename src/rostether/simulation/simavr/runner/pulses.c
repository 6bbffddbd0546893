/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Pulses: PWM as the timers are set, and servo pulses, by software or by a timer, on any pin.
 * A servo's angle as in the usual library: 544 us is 0 degrees, 2400 us is 180.
 */
#include <math.h>

#include "board.h"

#define MAX_WATCHED 16
#define LONGEST_SERVO_PULSE_US 3000.0
#define SHORTEST_SERVO_PULSE_US 300.0
/* A degree, in the whole microseconds of Servo.write. Interrupts delay the edges of a pulse made by software by
   half of that; it is not a new angle. */
#define NEW_ANGLE_US 9.5
#define ZERO_DEGREES_US 544.0
#define US_PER_DEGREE ((2400.0 - 544.0) / 180.0)

struct servo {
    struct pin *pin;
    cycles_t rose;
    double pulse_us, told_us;
};

static struct servo servos[MAX_WATCHED];
static struct {
    struct pin *pin;
    struct pwm told;
} watched[MAX_WATCHED];

const char *pulses_watch_pwm(struct pin *pin, bool on) {
    if (on && !timers_drive(pin_place(pin))) return NULL;
    int place = -1;
    for (int i = MAX_WATCHED; i-- > 0;)
        if (watched[i].pin == pin)
            place = i;
        else if (!watched[i].pin && (place < 0 || watched[place].pin != pin))
            place = i;
    if (place < 0) return on ? "too many pins are watched" : NULL;
    watched[place].pin = on ? pin : NULL;
    watched[place].told = (struct pwm){0};
    return NULL;
}

static void tell_pwm(const struct pin *pin, struct pwm pwm) {
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

static void tell_servo(struct servo *servo) {
    servo->told_us = servo->pulse_us;
    event_begin("servo");
    event_text("pin", pin_name(servo->pin));
    event_number("pulse_us", servo->pulse_us, 3);
    event_number("angle_deg", (servo->pulse_us - ZERO_DEGREES_US) / US_PER_DEGREE, 3);
    event_end_droppable();
}

static void take_pulse(struct servo *servo, double pulse_us) {
    if (pulse_us < SHORTEST_SERVO_PULSE_US || pulse_us > LONGEST_SERVO_PULSE_US) return;
    servo->pulse_us = pulse_us;
    if (fabs(pulse_us - servo->told_us) >= NEW_ANGLE_US) tell_servo(servo);
}

static void on_edge(struct pin *pin, bool level) {
    struct servo *servo = servo_on(pin);
    if (!servo || timers_pwm(pin_place(pin)).active) return;
    if (level)
        servo->rose = board.avr->cycle;
    else if (servo->rose)
        take_pulse(servo, (double)(board.avr->cycle - servo->rose) / CYCLES_PER_US);
}

const char *pulses_watch_servo(struct pin *pin, bool on) {
    struct servo *servo = servo_on(pin);
    if (on && !servo) {
        servo = servo_on(NULL);
        if (!servo) return "too many servos are watched";
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
    tell_servo(servo);
    return true;
}

/* Once a slice: the timers of watched pins. */
void pulses_look(void) {
    for (int i = 0; i < MAX_WATCHED; i++) {
        if (watched[i].pin) {
            struct pwm pwm = timers_pwm(pin_place(watched[i].pin));
            struct pwm *told = &watched[i].told;
            if (pwm.active != told->active || fabs(pwm.duty - told->duty) > 1e-6 ||
                fabs(pwm.period_us - told->period_us) > 1e-3)
                tell_pwm(watched[i].pin, *told = pwm);
        }
        if (servos[i].pin) {
            struct pwm pwm = timers_pwm(pin_place(servos[i].pin));
            if (pwm.active && pwm.period_us > LONGEST_SERVO_PULSE_US) take_pulse(&servos[i], pwm.duty * pwm.period_us);
        }
    }
}

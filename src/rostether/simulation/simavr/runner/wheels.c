/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Two motors with a wheel each, and the robot's pose. Each motor has a PWM pin and a direction pin, as on Arduino's
 * motor shields; a high direction pin means backwards. The speed follows the duty cycle immediately.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"

/* A Magician chassis: 65 mm wheels at 140 turns a minute, 0.14 m apart. */
static double full_speed = 0.48, track = 0.14;
static struct motor {
    struct pin *pwm, *direction;
} left, right;
static double x, y, heading;
static cycles_t moved_at;

static double duty(const struct motor *motor) {
    if (!pin_is_output(motor->pwm)) return 0;
    struct pwm pwm = timers_pwm(pin_place(motor->pwm));
    double forward = pwm.active ? pwm.duty : pin_level(motor->pwm);
    return pin_is_output(motor->direction) && pin_level(motor->direction) ? -forward : forward;
}

/* Moves the robot, between slices. */
void wheels_move(void) {
    if (!left.pwm) return;
    double seconds = (double)(board.avr->cycle - moved_at) / CLOCK_HZ;
    moved_at = board.avr->cycle;
    if (!board.powered) return;
    double l = duty(&left) * full_speed * seconds, r = duty(&right) * full_speed * seconds;
    double halfway = heading + (r - l) / track / 2;
    x += (l + r) / 2 * cos(halfway);
    y += (l + r) / 2 * sin(halfway);
    heading = remainder(heading + (r - l) / track, 2 * M_PI);
}

static bool wire(struct motor *motor, char *pins) {
    char *direction = strchr(pins, '/');
    if (!direction) return false;
    *direction++ = 0;
    struct motor wired = {pin_named(pins), pin_named(direction)};
    if (!wired.pwm || !wired.direction || pin_place(wired.pwm)->bit < 0 || pin_place(wired.direction)->bit < 0) return false;
    *motor = wired;
    return true;
}

static bool set_number(double *number, const char *text) {
    char *rest;
    double value = strtod(text, &rest);
    if (rest == text || *rest || !(value > 0 && value < 100)) return false;
    *number = value;
    return true;
}

static bool set_one(char *part) {
    char *value = strchr(part, '=');
    if (!value) return false;
    *value++ = 0;
    if (strcmp(part, "left") == 0) return wire(&left, value);
    if (strcmp(part, "right") == 0) return wire(&right, value);
    if (strcmp(part, "speed") == 0) return set_number(&full_speed, value);
    return strcmp(part, "track") == 0 && set_number(&track, value);
}

/* Reads left=D3/D8,right=D9/D7,speed=0.48,track=0.14. */
const char *wheels_set(char *settings) {
    char *rest = NULL;
    bool fits = true;
    wheels_start();
    for (char *part = strtok_r(settings, ",", &rest); fits && part; part = strtok_r(NULL, ",", &rest)) fits = set_one(part);
    return fits ? NULL : "write the pins for PWM and direction, and meters, as in wheels left=D3/D8,right=D9/D7,speed=0.48,track=0.14";
}

void wheels_start(void) {
    if (left.pwm) return;
    left = (struct motor){pin_named("D3"), pin_named("D8")};
    right = (struct motor){pin_named("D9"), pin_named("D7")};
    moved_at = board.avr->cycle;
}

void wheels_report(void) {
    wheels_start();
    event_begin("wheels");
    event_number("left", duty(&left), 4);
    event_number("right", duty(&right), 4);
    event_number("speed_m_s", (duty(&left) + duty(&right)) / 2 * full_speed, 4);
    event_number("turn_rad_s", (duty(&right) - duty(&left)) / track * full_speed, 4);
    event_number("x_m", x, 4);
    event_number("y_m", y, 4);
    event_number("heading_rad", heading, 4);
    event_end_droppable();
}

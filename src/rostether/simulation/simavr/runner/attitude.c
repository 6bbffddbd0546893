/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The board's attitude, and the values of its sensors. Axes: x forward, y left, z up. Roll, pitch and yaw are
 * right-handed rotations about x, y and z; yaw is applied first (as in ROS). At yaw 0, x points to magnetic north.
 */
#include <math.h>

#include "board.h"

#define DEGREE (M_PI / 180)
/* The Earth's field in central Europe: 20 µT to the north, 44 µT down. */
#define FIELD_NORTH_UT 20.0
#define FIELD_DOWN_UT 44.0

static struct vector from, to; /* x roll, y pitch, z yaw, in radians */
static cycles_t started;
static double duration;

static struct vector now(double *moving) {
    double done = duration > 0 ? (double)(board.avr->cycle - started) / CLOCK_HZ / duration : 1;
    *moving = done < 1;
    if (done >= 1) return to;
    return (struct vector){from.x + (to.x - from.x) * done, from.y + (to.y - from.y) * done,
                           from.z + (to.z - from.z) * done};
}

void attitude_set(double roll, double pitch, double yaw, double duration_s) {
    double moving;
    from = now(&moving);
    to = (struct vector){roll * DEGREE, pitch * DEGREE, yaw * DEGREE};
    started = board.avr->cycle;
    duration = duration_s;
}

/* Converts a vector from the world's axes to the board's axes. */
static struct vector to_board(struct vector world, struct vector angles) {
    double cr = cos(angles.x), sr = sin(angles.x), cp = cos(angles.y), sp = sin(angles.y);
    double cy = cos(angles.z), sy = sin(angles.z);
    return (struct vector){
        cy * cp * world.x + sy * cp * world.y - sp * world.z,
        (cy * sp * sr - sy * cr) * world.x + (sy * sp * sr + cy * cr) * world.y + cp * sr * world.z,
        (cy * sp * cr + sy * sr) * world.x + (sy * sp * cr - cy * sr) * world.y + cp * cr * world.z,
    };
}

void attitude_measure(struct vector *gravity_g, struct vector *turn_rate_dps, struct vector *field_ut) {
    double moving;
    struct vector angles = now(&moving);
    double scale = moving != 0 ? 1 / duration / DEGREE : 0;
    double roll = (to.x - from.x) * scale, pitch = (to.y - from.y) * scale, yaw = (to.z - from.z) * scale;
    double cr = cos(angles.x), sr = sin(angles.x), cp = cos(angles.y), sp = sin(angles.y);
    /* An accelerometer at rest measures the supporting force, which points up. */
    *gravity_g = to_board((struct vector){0, 0, 1}, angles);
    *turn_rate_dps = (struct vector){roll - yaw * sp, pitch * cr + yaw * cp * sr, yaw * cp * cr - pitch * sr};
    *field_ut = to_board((struct vector){FIELD_NORTH_UT, 0, -FIELD_DOWN_UT}, angles);
}

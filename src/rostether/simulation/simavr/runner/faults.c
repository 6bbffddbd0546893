/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A bad line, reproducible by its seed: flipped bits, lost and late bytes, with a rate for each direction. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"

#define DEFAULT_DELAY_MS 20.0
#define LONGEST_DELAY_MS 10000.0

struct rates {
    double flip, drop, delay, delay_ms;
    uint64_t state;
};

static struct rates lines[2] = {
    {0, 0, 0, DEFAULT_DELAY_MS, 1},
    {0, 0, 0, DEFAULT_DELAY_MS, 2},
};

/* Returns a random number from 0 up to 1. */
static double next_random(struct rates *line) {
    /* splitmix64 */
    uint64_t mixed = line->state += 0x9e3779b97f4a7c15ull;
    mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9ull;
    mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111ebull;
    return (double)((mixed ^ mixed >> 31) >> 11) / 9007199254740992.0;
}

struct faulty_byte faults_apply(enum direction direction, uint8_t byte) {
    struct rates *line = &lines[direction];
    struct faulty_byte result = {byte, false, false};
    if (line->flip == 0 && line->drop == 0 && line->delay == 0) return result;
    /* Always four random numbers a byte, so that one rate does not change the faults of another. */
    bool flips = next_random(line) < line->flip;
    unsigned bit = (unsigned)(next_random(line) * 8);
    result.lost = next_random(line) < line->drop;
    result.delayed = next_random(line) < line->delay;
    if (flips) result.byte = (uint8_t)(byte ^ 1u << bit);
    return result;
}

cycles_t faults_delay_cycles(enum direction direction) {
    return (cycles_t)(lines[direction].delay_ms * CYCLES_PER_MS);
}

static const char *set_one(struct rates *line, const char *key, const char *text) {
    char *rest;
    double value = strtod(text, &rest);
    if (rest == text || *rest) return "write a fault with a number, as in flip=0.01";
    bool is_rate = value >= 0 && value <= 1;
    if (strcmp(key, "seed") == 0 && value >= 0 && value < 9e15)
        line->state = (uint64_t)value * 2 + (line == &lines[FROM_BOARD]);
    else if (strcmp(key, "delay_ms") == 0 && value >= 0 && value <= LONGEST_DELAY_MS)
        line->delay_ms = value;
    else if (strcmp(key, "flip") == 0 && is_rate)
        line->flip = value;
    else if (strcmp(key, "drop") == 0 && is_rate)
        line->drop = value;
    else if (strcmp(key, "delay") == 0 && is_rate)
        line->delay = value;
    else
        return "faults are flip, drop and delay with rates from 0 to 1, delay_ms up to 10000, and seed";
    return NULL;
}

/* Reads flip=0.01,drop=0.001,to:delay=0.1,seed=3 or none; an invalid part changes nothing. */
const char *faults_set(char *settings) {
    struct rates before[2] = {lines[0], lines[1]};
    if (strcmp(settings, "none") == 0) {
        for (int i = 0; i < 2; i++) lines[i].flip = lines[i].drop = lines[i].delay = 0;
        return NULL;
    }
    char *rest = NULL;
    for (char *part = strtok_r(settings, ",", &rest); part; part = strtok_r(NULL, ",", &rest)) {
        bool to = true, from = true;
        if (strncmp(part, "to:", 3) == 0) {
            from = false;
            part += 3;
        } else if (strncmp(part, "from:", 5) == 0) {
            to = false;
            part += 5;
        }
        char *value = strchr(part, '=');
        const char *error = value ? NULL : "write a fault with a number, as in flip=0.01";
        if (value) *value++ = 0;
        if (!error && to) error = set_one(&lines[TO_BOARD], part, value);
        if (!error && from) error = set_one(&lines[FROM_BOARD], part, value);
        if (error) {
            memcpy(lines, before, sizeof lines);
            return error;
        }
    }
    return NULL;
}

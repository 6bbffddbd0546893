/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The boards and their pins, as in the variants of Arduino's core. */
#include <stdlib.h>
#include <string.h>

#include "board.h"

#define PIN(name, port, bit) {name, port, bit, -1}
#define ANALOG(name, port, bit, channel) {name, port, bit, channel}
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

#define STANDARD_PINS                                                                                       \
    PIN("D0", 'D', 0), PIN("D1", 'D', 1), PIN("D2", 'D', 2), PIN("D3", 'D', 3), PIN("D4", 'D', 4),          \
        PIN("D5", 'D', 5), PIN("D6", 'D', 6), PIN("D7", 'D', 7), PIN("D8", 'B', 0), PIN("D9", 'B', 1),      \
        PIN("D10", 'B', 2), PIN("D11", 'B', 3), PIN("D12", 'B', 4), PIN("D13", 'B', 5),                     \
        ANALOG("A0", 'C', 0, 0), ANALOG("A1", 'C', 1, 1), ANALOG("A2", 'C', 2, 2),                          \
        ANALOG("A3", 'C', 3, 3), ANALOG("A4", 'C', 4, 4), ANALOG("A5", 'C', 5, 5)

static const struct pin_place uno_pins[] = {STANDARD_PINS};

/* Its chip has eight analog inputs; the last two are not digital pins. */
static const struct pin_place nano_pins[] = {STANDARD_PINS, ANALOG("A6", 0, -1, 6), ANALOG("A7", 0, -1, 7)};

static const struct pin_place mega_pins[] = {
    PIN("D0", 'E', 0), PIN("D1", 'E', 1), PIN("D2", 'E', 4), PIN("D3", 'E', 5), PIN("D4", 'G', 5),
    PIN("D5", 'E', 3), PIN("D6", 'H', 3), PIN("D7", 'H', 4), PIN("D8", 'H', 5), PIN("D9", 'H', 6),
    PIN("D10", 'B', 4), PIN("D11", 'B', 5), PIN("D12", 'B', 6), PIN("D13", 'B', 7), PIN("D14", 'J', 1),
    PIN("D15", 'J', 0), PIN("D16", 'H', 1), PIN("D17", 'H', 0), PIN("D18", 'D', 3), PIN("D19", 'D', 2),
    PIN("D20", 'D', 1), PIN("D21", 'D', 0), PIN("D22", 'A', 0), PIN("D23", 'A', 1), PIN("D24", 'A', 2),
    PIN("D25", 'A', 3), PIN("D26", 'A', 4), PIN("D27", 'A', 5), PIN("D28", 'A', 6), PIN("D29", 'A', 7),
    PIN("D30", 'C', 7), PIN("D31", 'C', 6), PIN("D32", 'C', 5), PIN("D33", 'C', 4), PIN("D34", 'C', 3),
    PIN("D35", 'C', 2), PIN("D36", 'C', 1), PIN("D37", 'C', 0), PIN("D38", 'D', 7), PIN("D39", 'G', 2),
    PIN("D40", 'G', 1), PIN("D41", 'G', 0), PIN("D42", 'L', 7), PIN("D43", 'L', 6), PIN("D44", 'L', 5),
    PIN("D45", 'L', 4), PIN("D46", 'L', 3), PIN("D47", 'L', 2), PIN("D48", 'L', 1), PIN("D49", 'L', 0),
    PIN("D50", 'B', 3), PIN("D51", 'B', 2), PIN("D52", 'B', 1), PIN("D53", 'B', 0),
    ANALOG("A0", 'F', 0, 0), ANALOG("A1", 'F', 1, 1), ANALOG("A2", 'F', 2, 2), ANALOG("A3", 'F', 3, 3),
    ANALOG("A4", 'F', 4, 4), ANALOG("A5", 'F', 5, 5), ANALOG("A6", 'F', 6, 6), ANALOG("A7", 'F', 7, 7),
    ANALOG("A8", 'K', 0, 8), ANALOG("A9", 'K', 1, 9), ANALOG("A10", 'K', 2, 10), ANALOG("A11", 'K', 3, 11),
    ANALOG("A12", 'K', 4, 12), ANALOG("A13", 'K', 5, 13), ANALOG("A14", 'K', 6, 14),
    ANALOG("A15", 'K', 7, 15),
};

/* Arduino's D24 to D29 are second names of the pins with A6 to A11; D30 is the TX LED. */
static const struct pin_place leonardo_pins[] = {
    PIN("D0", 'D', 2), PIN("D1", 'D', 3), PIN("D2", 'D', 1), PIN("D3", 'D', 0), PIN("D4", 'D', 4),
    PIN("D5", 'C', 6), PIN("D6", 'D', 7), PIN("D7", 'E', 6), PIN("D8", 'B', 4), PIN("D9", 'B', 5),
    PIN("D10", 'B', 6), PIN("D11", 'B', 7), PIN("D12", 'D', 6), PIN("D13", 'C', 7), PIN("D14", 'B', 3),
    PIN("D15", 'B', 1), PIN("D16", 'B', 2), PIN("D17", 'B', 0), ANALOG("A0", 'F', 7, 7),
    ANALOG("A1", 'F', 6, 6), ANALOG("A2", 'F', 5, 5), ANALOG("A3", 'F', 4, 4), ANALOG("A4", 'F', 1, 1),
    ANALOG("A5", 'F', 0, 0), ANALOG("A6", 'D', 4, 8), ANALOG("A7", 'D', 7, 10), ANALOG("A8", 'B', 4, 11),
    ANALOG("A9", 'B', 5, 12), ANALOG("A10", 'B', 6, 13), ANALOG("A11", 'D', 6, 9), PIN("D30", 'D', 5),
};

static const struct board_kind kinds[] = {
    {"uno", "atmega328p", '0', uno_pins, COUNT(uno_pins)},
    {"nano", "atmega328p", '0', nano_pins, COUNT(nano_pins)},
    {"mega", "atmega2560", '0', mega_pins, COUNT(mega_pins)},
    {"leonardo", "atmega32u4", '1', leonardo_pins, COUNT(leonardo_pins)},
};

const struct board_kind *board_kind_named(const char *name) {
    for (size_t i = 0; i < COUNT(kinds); i++)
        if (strcmp(kinds[i].name, name) == 0) return &kinds[i];
    return NULL;
}

const struct pin_place *pin_place_named(const struct board_kind *kind, const char *name) {
    for (size_t i = 0; i < kind->pin_count; i++)
        if (strcmp(kind->pins[i].name, name) == 0) return &kind->pins[i];
    /* Plain numbers, as in sketches: 13 is D13. */
    if (name[0] >= '0' && name[0] <= '9' && strlen(name) < 3) {
        char digital[4] = "D";
        strcat(digital, name);
        return pin_place_named(kind, digital);
    }
    return NULL;
}

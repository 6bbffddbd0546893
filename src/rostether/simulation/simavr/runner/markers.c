/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Counts the cycles between two markers of the program: writing 1 to GPIOR2 begins a region, 0 ends it. The count
 * includes interrupt handlers, but not the two writes: an empty region has 0 cycles.
 */
#include "board.h"

#define GPIOR2 0x4b

static cycles_t began;
static bool inside;

static void on_write(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    (void)param;
    avr->data[address] = value;
    if (value == 1) {
        inside = true;
        began = avr->cycle;
    } else if (value == 0 && inside) {
        inside = false;
        event_begin("region");
        event_int("cycles", (long long)(avr->cycle - began) - 1);
        event_end_droppable();
    }
}

void markers_start(void) { avr_register_io_write(board.avr, GPIOR2, on_write, NULL); }

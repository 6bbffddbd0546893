/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Runs instructions until the next timer is due, then timers, then interrupts. instructions.c runs the common
 * instructions, the simulator the others. With guarded memory they run one by one, so that each store is checked.
 */
#include "board.h"
#include "instructions.h"

#include <sim_core.h>

static bool is_sleep_reported;

static void advance_asleep(cycles_t target) {
    avr_t *avr = board.avr;
    const avr_cycle_timer_slot_t *next = avr->cycle_timers.timer;
    if (!avr->sreg[S_I] && !is_sleep_reported) {
        is_sleep_reported = true;
        event_begin("asleep");
        event_text("text", "the program sleeps with interrupts off: only a reset wakes it");
        event_end();
    }
    avr->cycle = next && next->when < target ? (next->when > avr->cycle ? next->when : avr->cycle + 1) : target;
}

void core_reset(void) { is_sleep_reported = false; }

static void simulate_one(void) {
    avr_t *avr = board.avr;
    avr_flashaddr_t from = avr->pc;
    const uint8_t *code = avr->flash + from;
    unsigned opcode = code[0] | code[1] << 8;
    bool writes_flash = opcode == 0x95e8; /* SPM */
    bool moves_heap = board.heap_end_place && (opcode & 0xfe0f) == 0x9200 /* STS */ &&
                      (code[2] | code[3] << 8) == (int)board.heap_end_place;
    /* With a count of 0, the simulator returns after one instruction. */
    avr->run_cycle_count = 0;
    avr->pc = avr_run_one(avr);
    if (avr->state == cpu_Crashed) avr->state = cpu_Running;
    if (avr->pc == 0) canaries_report_restart(from);
    if (writes_flash) instructions_decode();
    if (moves_heap) canaries_heap_moved();
}

static void run_instructions(cycles_t target) {
    const avr_cycle_timer_slot_t *next = board.avr->cycle_timers.timer;
    cycles_t limit = next && next->when < target ? next->when : target;
    if (canaries_guarding) {
        canaries_check_store();
        limit = board.avr->cycle + 1;
    }
    if (!instructions_run(limit)) {
        simulate_one();
    } else if (board.avr->pc == 0) {
        canaries_report_restart(instructions_jumped_from);
    }
}

void core_run_until(cycles_t target) {
    avr_t *avr = board.avr;
    while (avr->cycle < target) {
        if (avr->state == cpu_Running)
            run_instructions(target);
        else
            advance_asleep(target);
        if (avr->cycle_timers.timer && avr->cycle_timers.timer->when <= avr->cycle) {
            avr_cycle_timer_process(avr);
            if (avr->run != avr_callback_run_raw) {
                /* The simulator has changed the callback to request the reset of an expired watchdog. */
                avr->run = avr_callback_run_raw;
                power_reset("watchdog");
            }
        }
        if (!avr->interrupt_state) continue;
        avr_flashaddr_t interrupted = avr->pc;
        avr_service_interrupts(avr);
        if (canaries_guarding && avr->pc != interrupted) canaries_check_interrupt();
    }
}

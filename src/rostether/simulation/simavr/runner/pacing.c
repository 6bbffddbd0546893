/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The main loop: it runs a slice of the board's time, exchanges data with the host and the network, and sleeps until the
 * real time has caught up. A slice is as long as the latency of a USB serial port.
 */
#include <errno.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

#include "board.h"

#define SLICE CYCLES_PER_MS
/* After a longer pause (suspend, heavy load), the board continues without catching up. */
#define LONGEST_CATCH_UP_NS 250000000ll

static int64_t base_ns;
static cycles_t base_cycle;

static int64_t now_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

void pacing_rebase(void) {
    base_ns = now_ns();
    base_cycle = board.avr->cycle;
}

static void wait_for_commands(int64_t timeout_ns) {
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    struct timespec timeout = {timeout_ns / 1000000000, timeout_ns % 1000000000};
    if (ppoll(&input, 1, timeout_ns < 0 ? NULL : &timeout, NULL) > 0) commands_read();
}

static void wait_for_clock(void) {
    while (!board.quitting && board.running) {
        int64_t due_ns = base_ns + (int64_t)((board.avr->cycle - base_cycle) * 1000 / CYCLES_PER_US);
        int64_t now = now_ns();
        if (now - due_ns > LONGEST_CATCH_UP_NS) {
            event_begin("behind");
            event_int("lost_ms", (now - due_ns) / 1000000);
            event_end();
            pacing_rebase();
        }
        wait_for_commands(due_ns > now ? due_ns - now : 0);
        if (due_ns - now_ns() <= 0) return;
    }
}

static void stop(void) {
    board.running = false;
    board.stop_at = NEVER;
    event_begin("stopped");
    event_int("cycles", (long long)board.avr->cycle);
    event_end();
    if (board.quits_at_stop) board.quitting = true;
}

static void run_slice(void) {
    cycles_t end = board.avr->cycle + SLICE;
    if (end > board.stop_at) end = board.stop_at;
    link_receive();
    network_move();
    w5100_move();
    if (board.powered)
        core_run_until(end);
    else
        board.avr->cycle = end;
    uart_report_overruns();
    pulses_update();
    wheels_move();
    canaries_check_stack();
    link_flush();
    if (board.avr->cycle >= board.stop_at) stop();
}

int pacing_loop(void) {
    pacing_rebase();
    while (!board.quitting) {
        if (!board.running) {
            events_flush();
            wait_for_commands(-1);
            continue;
        }
        run_slice();
        events_flush();
        if (board.fast)
            wait_for_commands(0);
        else
            wait_for_clock();
    }
    link_flush();
    link_close();
    events_flush();
    return 0;
}

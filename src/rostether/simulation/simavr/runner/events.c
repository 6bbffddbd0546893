/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Events, one JSON object per line: {"event":"pin","time_us":1234.5,"pin":"D13","level":1}.
 * time_us is the board's time since its start, exact to the cycle. Frequent events are dropped if no program reads
 * them in time; their number is reported.
 */
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "board.h"

/* Room for a few thousand events: a reader may pause for a second. */
#define ROOM (512 * 1024)
#define LONGEST_EVENT (64 * 1024)
/* If poll reports a pipe as writable, a write of PIPE_BUF (4096) bytes does not block. */
#define CHUNK 4096

static int output = -1;
static char pending[ROOM];
static size_t pending_count;
static char event[LONGEST_EVENT];
static size_t length;
static unsigned long lost;

void events_open(int fd) { output = fd; }

static void put(const char *text, size_t count) {
    if (length + count < LONGEST_EVENT) {
        memcpy(event + length, text, count);
        length += count;
    }
}

static void put_string(const char *text) {
    put("\"", 1);
    for (; *text; text++) {
        unsigned char character = (unsigned char)*text;
        char escaped[8];
        if (character == '"' || character == '\\')
            put(escaped, (size_t)snprintf(escaped, sizeof escaped, "\\%c", character));
        else if (character < 0x20 || character > 0x7e)
            put(escaped, (size_t)snprintf(escaped, sizeof escaped, "\\u%04x", character));
        else
            put(text, 1);
    }
    put("\"", 1);
}

static void put_key(const char *key) {
    put(",", 1);
    put_string(key);
    put(":", 1);
}

void event_begin(const char *name) {
    char time[48];
    cycles_t cycle = board.avr ? board.avr->cycle : 0;
    length = 0;
    put("{\"event\":", 9);
    put_string(name);
    put(time, (size_t)snprintf(time, sizeof time, ",\"time_us\":%.4f", (double)cycle / CYCLES_PER_US));
}

void event_text(const char *key, const char *value) {
    put_key(key);
    put_string(value);
}

void event_int(const char *key, long long value) {
    char text[24];
    put_key(key);
    put(text, (size_t)snprintf(text, sizeof text, "%lld", value));
}

void event_number(const char *key, double value, int decimals) {
    char text[64];
    put_key(key);
    put(text, (size_t)snprintf(text, sizeof text, "%.*f", decimals, value));
}

void event_bool(const char *key, bool value) {
    put_key(key);
    put(value ? "true" : "false", value ? 4 : 5);
}

void event_hex(const char *key, const uint8_t *bytes, size_t count) {
    static const char digits[] = "0123456789abcdef";
    put_key(key);
    put("\"", 1);
    for (size_t i = 0; i < count; i++) {
        char pair[2] = {digits[bytes[i] >> 4], digits[bytes[i] & 15]};
        put(pair, 2);
    }
    put("\"", 1);
}

static bool is_writable(int timeout_ms) {
    struct pollfd wanted = {.fd = output, .events = POLLOUT};
    return poll(&wanted, 1, timeout_ms) > 0;
}

static void drain(size_t keep) {
    size_t written = 0;
    while (pending_count - written > keep) {
        size_t count = pending_count - written;
        if (!board.fast && !board.quitting && !is_writable(0)) break;
        ssize_t result = write(output, pending + written, count < CHUNK ? count : CHUNK);
        if (result < 0 && errno == EINTR) continue;
        if (result < 0) {
            /* The program that started this one has ended. */
            board.quitting = true;
            pending_count = 0;
            return;
        }
        written += (size_t)result;
    }
    memmove(pending, pending + written, pending_count - written);
    pending_count -= written;
}

static void finish(bool droppable) {
    put("}\n", 2);
    /* The last part is reserved for events that must not be lost: answers and errors. */
    size_t room = droppable ? ROOM - 4 * LONGEST_EVENT : ROOM;
    if (pending_count + length > room) drain(0);
    if (pending_count + length > room) {
        lost++;
        return;
    }
    memcpy(pending + pending_count, event, length);
    pending_count += length;
}

void event_end(void) { finish(false); }

void event_end_droppable(void) { finish(true); }

void events_flush(void) {
    drain(0);
    if (lost && pending_count < ROOM / 2) {
        unsigned long count = lost;
        lost = 0;
        event_begin("lost_events");
        event_int("count", (long long)count);
        event_end();
    }
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Signs of a faulty program: a stack that comes close to the variables, a restart without a reset, accesses to
 * addresses without memory, invalid opcodes, and writes into guarded memory.
 *
 * RAM has noise at power-up. The stack has never used the bytes that still have their noise; counting them costs
 * nothing while the program runs. The count may be a few bytes too high, if the program wrote the same values by
 * chance. The heap also changes bytes (String objects, for example), so the search begins above its highest end.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"

#include <sim_core.h>

#define MAX_GUARDS 16
/* A faulty program repeats its fault; the first reports are enough to find the place. */
#define MAX_REPORTS 100
#define SCARCE_BYTES 64

bool canaries_guarding;
static struct {
    uint32_t from, end;
} guards[MAX_GUARDS];
static int guard_count, reports;
static uint8_t *noise;
static int lowest_reported;
static uint32_t highest_heap_end;

static bool may_report(void) { return reports < MAX_REPORTS && ++reports; }

static void on_log(avr_t *avr, const int level, const char *format, va_list values) {
    char text[256];
    if (level > LOG_WARNING || !avr) return;
    vsnprintf(text, sizeof text, format, values);
    const char *kind = strstr(text, "Invalid Opcode")  ? "bad_opcode"
                       : strstr(text, "Invalid write") ? "bad_write"
                       : strstr(text, "Invalid read")  ? "bad_read"
                                                       : NULL;
    if (!kind || !may_report()) return;
    const char *address = strstr(text, "Address ");
    event_begin(kind);
    event_int("pc", avr->pc);
    if (address) event_int("address", strtol(address + strlen("Address "), NULL, 16));
    event_end_droppable();
}

void canaries_report_restart(uint32_t from) {
    if (!may_report()) return;
    event_begin("restart");
    event_int("pc", from);
    event_int("stack_pointer", _avr_sp_get(board.avr));
    event_text("text", from >= board.avr->codeend ? "the program ran past the end of its code and starts over without a reset"
                                                  : "the program jumped to its start without a reset");
    event_end_droppable();
}

void canaries_fill(void) {
    size_t size = (size_t)board.avr->ramend + 1;
    if (!noise) noise = malloc(size);
    if (noise) memcpy(noise, board.avr->data, size);
    lowest_reported = SCARCE_BYTES;
    highest_heap_end = 0;
    reports = 0;
}

void canaries_heap_moved(void) {
    uint32_t end = firmware_heap_end();
    if (end > highest_heap_end) highest_heap_end = end;
}

/*
 * Returns the bytes between the heap's highest end and the deepest stack since power-up; -1 for a program without
 * symbols. It is also 0 if the stack reached memory that the heap had already freed, which may be harmless.
 */
int canaries_free_stack(void) {
    const avr_t *avr = board.avr;
    uint32_t start = firmware_heap_start(), from = highest_heap_end > start ? highest_heap_end : start, at = from;
    if (!noise || from <= avr->ioend + 1u) return -1;
    while (at <= avr->ramend && avr->data[at] == noise[at]) at++;
    return (int)(at - from);
}

void canaries_check_stack(void) {
    int free_bytes = board.powered ? canaries_free_stack() : -1;
    if (free_bytes < 0 || free_bytes >= lowest_reported) return;
    lowest_reported = free_bytes;
    uint32_t heap_end = firmware_heap_end();
    bool is_overflow = !free_bytes && (highest_heap_end <= heap_end || _avr_sp_get(board.avr) < heap_end);
    event_begin(is_overflow ? "stack_overflow" : "stack_low");
    event_int("free_bytes", free_bytes);
    event_end();
}

/* Reads a symbol, an address, or FROM..TO (without TO); returns false for another text. */
bool canaries_place(const char *text, uint32_t *from, uint32_t *end) {
    const struct symbol *symbol = firmware_symbol(text);
    char *rest;
    if (symbol) {
        *from = symbol->address;
        *end = symbol->address + (symbol->size ? symbol->size : 1);
    } else {
        *from = (uint32_t)strtoul(text, &rest, 0);
        if (rest == text) return false;
        *end = *from + 1;
        if (strncmp(rest, "..", 2) == 0) *end = (uint32_t)strtoul(rest + 2, &rest, 0);
        if (*rest) return false;
    }
    return *from < *end && *end <= board.avr->ramend + 1u;
}

const char *canaries_guard(const char *place) {
    uint32_t from, end;
    if (strcmp(place, "none") == 0) {
        guard_count = 0;
        canaries_guarding = false;
        return NULL;
    }
    if (!canaries_place(place, &from, &end)) return "guard a symbol of the program, or addresses such as 0x100..0x180";
    if (guard_count == MAX_GUARDS) return "too many guards; `guard none` removes them";
    guards[guard_count].from = from;
    guards[guard_count++].end = end;
    return canaries_guarding = true, NULL;
}

static void check(uint32_t address, unsigned count) {
    for (int i = 0; i < guard_count; i++) {
        if (address + count <= guards[i].from || address >= guards[i].end) continue;
        if (!may_report()) return;
        event_begin("guarded_write");
        event_int("address", address);
        event_int("pc", board.avr->pc);
        event_end_droppable();
        return;
    }
}

void canaries_check_interrupt(void) {
    check(_avr_sp_get(board.avr) + 1u, board.avr->address_size);
}

/* Checks the address at which the next instruction stores. */
void canaries_check_store(void) {
    avr_t *avr = board.avr;
    const uint8_t *code = avr->flash + avr->pc, *r = avr->data;
    unsigned opcode = code[0] | code[1] << 8, return_bytes = avr->address_size;
    uint32_t x = r[26] | r[27] << 8, y = r[28] | r[29] << 8, z = r[30] | r[31] << 8;
    uint32_t offset = (opcode & 7) | (opcode >> 7 & 0x18) | (opcode >> 8 & 0x20);
    if ((opcode & 0xd208) == 0x8200) return check(z + offset, 1);
    if ((opcode & 0xd208) == 0x8208) return check(y + offset, 1);
    if ((opcode & 0xf000) == 0xd000) return check(_avr_sp_get(avr) - return_bytes + 1, return_bytes); /* RCALL */
    if ((opcode & 0xfe0e) == 0x940e) return check(_avr_sp_get(avr) - return_bytes + 1, return_bytes); /* CALL */
    if ((opcode & 0xffef) == 0x9509) return check(_avr_sp_get(avr) - return_bytes + 1, return_bytes); /* ICALL */
    if ((opcode & 0xfe00) != 0x9200) return;
    switch (opcode & 0x0f) {
    case 0x0: /* STS */
        return check(code[2] | code[3] << 8, 1);
    case 0x1:
        return check(z, 1);
    case 0x2:
        return check(z - 1, 1);
    case 0x9:
        return check(y, 1);
    case 0xa:
        return check(y - 1, 1);
    case 0xc:
    case 0xd:
        return check(x, 1);
    case 0xe:
        return check(x - 1, 1);
    case 0xf: /* PUSH */
        return check(_avr_sp_get(avr), 1);
    }
}

void canaries_start(void) { avr_global_logger_set(on_log); }

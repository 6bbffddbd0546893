/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Runs each word of a flash with random words twice from the same random state: with the runner's instructions and with
 * the simulator's. Compares everything that an instruction can change, and prints the number of each kind.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"
#include "instructions.h"

#include <sim_core.h>

#define AS_NAME(name) #name,

struct board board;

static uint64_t seed = 88172645463325252ull;

static uint32_t pick(uint32_t below) {
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (uint32_t)(seed >> 16) % below;
}

struct state {
    uint8_t data[0x2300], flags[8];
    uint32_t pc;
    uint64_t cycle;
    int interrupt_state;
};

static void save(struct state *state) {
    const avr_t *avr = board.avr;
    memcpy(state->data, avr->data, avr->ramend + 1u);
    memcpy(state->flags, avr->sreg, 8);
    state->pc = avr->pc;
    state->cycle = avr->cycle;
    state->interrupt_state = avr->interrupt_state;
}

static void restore(const struct state *state) {
    avr_t *avr = board.avr;
    memcpy(avr->data, state->data, avr->ramend + 1u);
    memcpy(avr->sreg, state->flags, 8);
    avr->pc = state->pc;
    avr->cycle = state->cycle;
    avr->interrupt_state = (int8_t)state->interrupt_state;
}

static void put_word(uint32_t place, uint32_t value) {
    board.avr->data[place] = (uint8_t)value;
    board.avr->data[place + 1] = (uint8_t)(value >> 8);
}

/* Returns a pointer, mostly into RAM, sometimes to its edges or to any address. */
static uint32_t pick_pointer(void) {
    uint32_t first = board.avr->ioend + 1u, end = board.avr->ramend + 1u;
    switch (pick(16)) {
    case 0:
        return pick(0x10000);
    case 1:
        return first - 3 + pick(6);
    case 2:
        return end - 4 + pick(6);
    default:
        return first + pick(end - first);
    }
}

static void randomise(uint32_t pc) {
    static const uint32_t corners[] = {0x00, 0x01, 0x7f, 0x80, 0xff};
    avr_t *avr = board.avr;
    for (int i = 0; i < 32; i++) avr->data[i] = (uint8_t)(pick(4) ? pick(256) : corners[pick(5)]);
    for (int i = 0; i < 40; i++) avr->data[avr->ioend + 1 + pick(avr->ramend - avr->ioend)] = (uint8_t)pick(256);
    for (int i = 26; i < 32; i += 2) put_word((uint32_t)i, pick_pointer());
    uint32_t stack = pick_pointer(), target = pick((avr->flashend + 1) / 2);
    put_word(R_SPL, stack);
    /* An address to return to. */
    for (int i = avr->address_size; pick(8) && i > 0; i--, target >>= 8) avr->data[stack + (uint32_t)i] = (uint8_t)target;
    if (!pick(2)) put_word(30, pick((avr->flashend + 1) / 2));
    for (int i = 0; i < 8; i++) avr->sreg[i] = (uint8_t)pick(2);
    avr->pc = pc;
    avr->cycle = 1000;
    avr->interrupt_state = pick(2) ? 0 : 1;
}

/* These are few of all opcodes, but common in programs. */
static const uint16_t rare[][2] = {
    {0x9508, 0x0000}, {0x9409, 0x0000}, {0x9509, 0x0000}, {0x940c, 0x0001}, {0x940e, 0x0001}, {0x9000, 0x01f0},
    {0x9200, 0x01f0}, {0x900f, 0x01f0}, {0x920f, 0x01f0}, {0x9004, 0x01f1}, {0x95c8, 0x0000}, {0x9408, 0x00f0},
    {0x0000, 0x0000}, {0x9400, 0x01ff}, {0xb63f, 0x0000}, {0xbe0f, 0x0000}, {0x9600, 0x01ff},
};

static void fill_flash(void) {
    avr_t *avr = board.avr;
    for (uint32_t i = 0; i <= avr->flashend; i++) avr->flash[i] = (uint8_t)pick(256);
    for (uint32_t i = 0; i < avr->flashend; i += 2) {
        const uint16_t *opcode = rare[pick(sizeof rare / sizeof *rare)];
        uint32_t code = opcode[0] | (pick(0x10000) & opcode[1]);
        if (pick(3)) continue;
        avr->flash[i] = (uint8_t)code;
        avr->flash[i + 1] = (uint8_t)(code >> 8);
    }
    /* Addresses of RAM behind LDS and STS. */
    for (uint32_t i = 0; i + 3 < avr->flashend; i += 2)
        if ((avr->flash[i] & 0x0f) == 0 && (avr->flash[i + 1] & 0xfc) == 0x90 && pick(4)) {
            uint32_t address = pick_pointer();
            avr->flash[i + 2] = (uint8_t)address;
            avr->flash[i + 3] = (uint8_t)(address >> 8);
        }
}

/*
 * When libsimavr 1.6 skips ADIW and SBIW with certain operands, it treats them as instructions of two words. The chip and
 * the runner do not.
 */
static bool is_simulator_error(uint32_t pc) {
    const uint8_t *next = board.avr->flash + pc + 2;
    return (next[1] & 0xfe) == 0x96 && (next[0] & 0x0c) == 0x0c;
}

static bool same(const struct state *runner, const struct state *simavr) {
    return memcmp(runner->data, simavr->data, board.avr->ramend + 1u) == 0 &&
           memcmp(runner->flags, simavr->flags, 8) == 0 && runner->pc == simavr->pc &&
           runner->cycle == simavr->cycle && runner->interrupt_state == simavr->interrupt_state;
}

static void explain(const char *name, const struct state *before, const struct state *runner, const struct state *simavr) {
    const uint8_t *code = board.avr->flash + before->pc;
    printf("%s %02x%02x: pc %x, runner %x, simavr %x; cycles %d, %d; interrupts %d, %d; flags", name, code[1], code[0],
           before->pc, runner->pc, simavr->pc, (int)(runner->cycle - before->cycle), (int)(simavr->cycle - before->cycle),
           runner->interrupt_state, simavr->interrupt_state);
    for (int i = 0; i < 8; i++) printf(" %d/%d", runner->flags[i], simavr->flags[i]);
    for (int i = 0; i <= board.avr->ramend; i++)
        if (runner->data[i] != simavr->data[i]) printf("; %x: %02x/%02x", (unsigned)i, runner->data[i], simavr->data[i]);
    printf("\n");
}

int main(int count, char **arguments) {
    static const char *const names[] = {OPERATIONS(AS_NAME)};
    static unsigned long compared[sizeof names / sizeof *names];
    static struct state before, runner, simavr;
    int wrong = 0;
    if (count != 3) return 2;
    avr_t *avr = board.avr = avr_make_mcu_by_name(arguments[1]);
    avr_init(avr);
    avr->data = realloc(avr->data, 0x10200);
    for (int round = 0; round < atoi(arguments[2]); round++) {
        fill_flash();
        avr->codeend = avr->flashend + 1;
        instructions_decode();
        for (uint32_t pc = 0; pc < avr->flashend && wrong < 20; pc += 2) {
            randomise(pc);
            save(&before);
            bool done = instructions_run(avr->cycle + 1);
            save(&runner);
            if (!done) {
                if (!same(&before, &runner)) wrong++, explain("changed by one left alone", &before, &runner, &before);
                continue;
            }
            restore(&before);
            avr->run_cycle_count = 0;
            avr->state = cpu_Running;
            avr->pc = avr_run_one(avr);
            save(&simavr);
            unsigned kind = operations[pc >> 1].kind;
            compared[kind]++;
            if (!same(&runner, &simavr) && !is_simulator_error(pc)) wrong++, explain(names[kind], &before, &runner, &simavr);
        }
    }
    for (size_t i = 1; i < sizeof names / sizeof *names; i++) printf("compared %s %lu\n", names[i], compared[i]);
    return wrong != 0;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The macros and functions of the labels in instructions.c: the flags, and the end of an instruction. */
#ifndef ARITHMETIC_H
#define ARITHMETIC_H

#include "board.h"

#include <sim_core.h>

#define FLAG(name, value) flags[S_##name] = (uint8_t)((value) & 1)
/* Each instruction has its own jump to the next one, because processors predict one shared jump badly. */
#define DISPATCH()                                                                                           \
    do {                                                                                                     \
        if (cycle >= limit) goto out;                                                                        \
        goto *labels[op->kind];                                                                              \
    } while (0)
#define NEXT(words, count)                                                                                   \
    do {                                                                                                     \
        cycle += (count);                                                                                    \
        op += (words);                                                                                       \
        DISPATCH();                                                                                          \
    } while (0)
#define JUMP(target, count)                                                                                  \
    do {                                                                                                     \
        from = op;                                                                                           \
        op = operations + ((uint32_t)(target) >> 1);                                                         \
        cycle += (count);                                                                                    \
        if (op == operations) goto restarted;                                                                \
        DISPATCH();                                                                                          \
    } while (0)
#define SKIP_IF(condition)                                                                                   \
    do {                                                                                                     \
        if (condition) NEXT(1 + op->k / 2, (uint32_t)op->k / 2 + 1);                                   \
        NEXT(1, 1);                                                                                          \
    } while (0)
/* Reading a peripheral's register may start timers and interrupts; they are checked after this instruction. */
#define ASK_PERIPHERAL()                                                                                     \
    do {                                                                                                     \
        avr->cycle = cycle;                                                                                  \
        data[op->d + 32] = avr->io[op->d].r.c(avr, (avr_io_addr_t)(op->d + 32), avr->io[op->d].r.param);     \
        limit = 0;                                                                                           \
    } while (0)
/* RAM begins after the registers of peripherals. */
#define NEEDS_RAM(address)                                                                                   \
    if ((uint32_t)(address) - ram < ram_size) {                                                              \
    } else                                                                                                   \
        goto simulator
#define NEEDS_STACK(bytes_above, bytes_below)                                                                \
    uint32_t sp = word(data + R_SPL);                                                                        \
    if (sp + (bytes_above) >= ram + ram_size || sp < ram + (bytes_below)) goto simulator
#define LOGIC(result)                                                                                        \
    do {                                                                                                     \
        uint8_t value = (uint8_t)(result);                                                                   \
        data[op->d] = value;                                                                                 \
        FLAG(Z, value == 0);                                                                                 \
        FLAG(N, value >> 7);                                                                                 \
        FLAG(V, 0);                                                                                          \
        FLAG(S, value >> 7);                                                                                 \
        NEXT(1, 1);                                                                                          \
    } while (0)

static inline uint16_t word(const uint8_t *bytes) { return (uint16_t)(bytes[0] | bytes[1] << 8); }

static inline void put_word(uint8_t *bytes, uint16_t value) {
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

static inline uint8_t add(uint8_t *flags, uint8_t d, uint8_t r, uint8_t carry) {
    uint8_t result = (uint8_t)(d + r + carry), carries = (uint8_t)((d & r) | (r & ~result) | (~result & d));
    FLAG(H, carries >> 3);
    FLAG(C, carries >> 7);
    FLAG(V, ((d & r & ~result) | (~d & ~r & result)) >> 7);
    FLAG(N, result >> 7);
    FLAG(Z, result == 0);
    FLAG(S, flags[S_N] ^ flags[S_V]);
    return result;
}

static inline uint8_t subtract(uint8_t *flags, uint8_t d, uint8_t r, uint8_t carry, bool keeps_zero) {
    uint8_t result = (uint8_t)(d - r - carry), borrows = (uint8_t)((~d & r) | (r & result) | (result & ~d));
    FLAG(H, borrows >> 3);
    FLAG(C, borrows >> 7);
    FLAG(V, ((d & ~r & ~result) | (~d & r & result)) >> 7);
    FLAG(N, result >> 7);
    FLAG(Z, result == 0 && (!keeps_zero || flags[S_Z]));
    FLAG(S, flags[S_N] ^ flags[S_V]);
    return result;
}

static inline uint8_t shifted(uint8_t *flags, uint8_t value, uint8_t result) {
    FLAG(C, value);
    FLAG(Z, result == 0);
    FLAG(N, result >> 7);
    FLAG(V, flags[S_N] ^ flags[S_C]);
    FLAG(S, flags[S_N] ^ flags[S_V]);
    return result;
}

static inline uint32_t push_address(uint8_t *data, uint32_t sp, uint32_t pc, unsigned bytes) {
    pc >>= 1;
    for (unsigned i = 0; i < bytes; i++, pc >>= 8) data[sp--] = (uint8_t)pc;
    put_word(data + R_SPL, (uint16_t)sp);
    return sp;
}

#endif

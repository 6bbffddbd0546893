/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Decodes the flash once: the operation and operands of each word, in the form that instructions.c needs. Rare
 * operations, and the flash after the program, are left to the simulator (OP_SIMULATOR).
 */
#include "instructions.h"

#include <stdlib.h>

#include "board.h"

struct operation *operations;

static uint16_t word_at(uint32_t pc) {
    const uint8_t *flash = board.avr->flash;
    return pc < board.avr->flashend ? (uint16_t)(flash[pc] | flash[pc + 1] << 8) : 0xffff;
}

static bool is_long(uint16_t code) { return (code & 0xfc0f) == 0x9000 || (code & 0xfe0c) == 0x940c; }

static bool moves_heap(uint16_t address) { return board.heap_end_place && address == board.heap_end_place; }

/* Returns the size of the instruction that a skip at pc omits. */
static int32_t skipped_bytes(uint32_t pc) { return is_long(word_at(pc + 2)) ? 4 : 2; }

static struct operation make(uint8_t kind, unsigned d, unsigned r, int32_t k) {
    return (struct operation){kind, (uint8_t)d, (uint8_t)r, k};
}

static struct operation decode_arithmetic(uint16_t code, uint32_t pc) {
    static const uint8_t kinds[12] = {OP_SIMULATOR, OP_CPC, OP_SBC, OP_ADD, OP_CPSE, OP_CP,
                                      OP_SUB,       OP_ADC, OP_AND, OP_EOR, OP_OR,   OP_MOV};
    unsigned d = code >> 4 & 0x1f, r = (code & 0x0f) | (code >> 5 & 0x10), kind = code >> 10;
    if (code == 0) return make(OP_NOP, 0, 0, 0);
    if (code >> 8 == 0x01) return make(OP_MOVW, (code >> 4 & 0xf) * 2, (code & 0xf) * 2, 0);
    return make(kinds[kind], d, r, kind == 4 ? skipped_bytes(pc) : 0);
}

static struct operation decode_immediate(uint16_t code) {
    static const uint8_t kinds[] = {OP_CPI, OP_SBCI, OP_SUBI, OP_ORI, OP_ANDI};
    unsigned d = 16 + (code >> 4 & 0xf), k = (code & 0xf) | (code >> 4 & 0xf0);
    return make(code >> 12 == 0xe ? OP_LDI : kinds[(code >> 12) - 3], d, 0, (int32_t)k);
}

static struct operation decode_displaced(uint16_t code) {
    unsigned d = code >> 4 & 0x1f;
    int32_t q = (code & 7) | (code >> 7 & 0x18) | (code >> 8 & 0x20);
    bool stores = code & 0x0200, y = code & 0x0008;
    return make(stores ? OP_STD : OP_LDD, d, y ? 28 : 30, q);
}

static struct operation decode_transfer(uint16_t code, uint32_t pc) {
    static const uint8_t pointers[16] = {0, 30, 30, 0, 0, 0, 0, 0, 0, 28, 28, 0, 26, 26, 26, 0};
    unsigned d = code >> 4 & 0x1f, mode = code & 0xf;
    bool stores = code & 0x0200;
    /* Compilers store the low byte of the heap's end last; core.c handles this store after the simulator. */
    if (mode == 0x0 && stores && moves_heap(word_at(pc + 2))) return make(OP_SIMULATOR, 0, 0, 0);
    if (mode == 0x0) return make(stores ? OP_STS : OP_LDS, d, 0, word_at(pc + 2));
    if (mode == 0xf) return make(stores ? OP_PUSH : OP_POP, d, 0, 0);
    if (!stores && (mode == 4 || mode == 5)) return make(mode == 4 ? OP_LPM : OP_LPM_INC, d, 0, 0);
    if (!pointers[mode]) return make(OP_SIMULATOR, 0, 0, 0);
    if (mode == 0xc) return make(stores ? OP_STD : OP_LDD, d, 26, 0);
    bool increments = mode == 1 || mode == 9 || mode == 0xd;
    uint8_t kind = stores ? (increments ? OP_ST_INC : OP_ST_DEC) : (increments ? OP_LD_INC : OP_LD_DEC);
    return make(kind, d, pointers[mode], 0);
}

static struct operation decode_single(uint16_t code, uint32_t pc) {
    static const uint8_t kinds[16] = {OP_COM, OP_NEG,       OP_SWAP, OP_INC,       OP_SIMULATOR, OP_ASR,
                                      OP_LSR, OP_ROR,       OP_SIMULATOR, OP_SIMULATOR, OP_DEC, OP_SIMULATOR,
                                      OP_JMP, OP_JMP,       OP_CALL, OP_CALL};
    unsigned d = code >> 4 & 0x1f, kind = code & 0xf;
    if (code == 0x9508) return make(OP_RET, 0, 0, 0);
    if (code == 0x9409) return make(OP_IJMP, 0, 0, 0);
    if (code == 0x9509) return make(OP_ICALL, 0, 0, 0);
    if (code == 0x95c8) return make(OP_LPM, 0, 0, 0);
    if ((code & 0xff8f) == 0x9408) return make(OP_BSET, code >> 4 & 7, 0, 0);
    if ((code & 0xff8f) == 0x9488) return make(OP_BCLR, code >> 4 & 7, 0, 0);
    uint32_t target = (((code >> 3 & 0x3eu) | (code & 1u)) << 16 | word_at(pc + 2)) << 1;
    return make(kinds[kind], d, 0, kind >= 0xc ? (int32_t)target : 0);
}

static struct operation decode_nine(uint16_t code, uint32_t pc) {
    unsigned pair = 24 + (code >> 4 & 3) * 2, k = (code & 0xf) | (code >> 2 & 0x30);
    switch (code >> 8 & 0xf) {
    case 0x0: case 0x1: case 0x2: case 0x3:
        return decode_transfer(code, pc);
    case 0x4: case 0x5:
        return decode_single(code, pc);
    case 0x6:
        return make(OP_ADIW, pair, 0, (int32_t)k);
    case 0x7:
        return make(OP_SBIW, pair, 0, (int32_t)k);
    case 0x9:
        return make(OP_SBIC, code >> 3 & 0x1f, code & 7, skipped_bytes(pc));
    case 0xb:
        return make(OP_SBIS, code >> 3 & 0x1f, code & 7, skipped_bytes(pc));
    case 0xc: case 0xd: case 0xe: case 0xf:
        return make(OP_MUL, code >> 4 & 0x1f, (code & 0xf) | (code >> 5 & 0x10), 0);
    default:
        return make(OP_SIMULATOR, 0, 0, 0);
    }
}

static struct operation decode_branch(uint16_t code, uint32_t pc) {
    unsigned d = code >> 4 & 0x1f, bit = code & 7;
    int32_t target = (int32_t)pc + 2 + ((int16_t)(uint16_t)(code << 6) >> 9) * 2;
    switch (code >> 9 & 7) {
    case 0: case 1:
        return make(OP_BRBS, bit, 0, target);
    case 2: case 3:
        return make(OP_BRBC, bit, 0, target);
    case 4:
        return make(code & 8 ? OP_SIMULATOR : OP_BLD, d, bit, 0);
    case 5:
        return make(code & 8 ? OP_SIMULATOR : OP_BST, d, bit, 0);
    default:
        return make(code & 8 ? OP_SIMULATOR : code & 0x200 ? OP_SBRS : OP_SBRC, d, bit, skipped_bytes(pc));
    }
}

static struct operation decode(uint32_t pc) {
    uint16_t code = word_at(pc);
    uint32_t size = board.avr->flashend + 1;
    int32_t relative = (int32_t)((pc + 2 + (uint32_t)(int32_t)((int16_t)(uint16_t)(code << 4) >> 3)) % size);
    unsigned port = (code & 0xf) | (code >> 5 & 0x30);
    switch (code >> 12) {
    case 0x0: case 0x1: case 0x2:
        return decode_arithmetic(code, pc);
    case 0x3: case 0x4: case 0x5: case 0x6: case 0x7: case 0xe:
        return decode_immediate(code);
    case 0x8: case 0xa:
        return decode_displaced(code);
    case 0x9:
        return decode_nine(code, pc);
    case 0xb:
        return make(code & 0x0800 ? OP_OUT : OP_IN, code >> 4 & 0x1f, port, 0);
    case 0xc:
        return make(OP_JMP_NEAR, 0, 0, relative);
    case 0xd:
        return make(OP_RCALL, 0, 0, relative);
    default:
        return decode_branch(code, pc);
    }
}

/* The simulator also handles jumps out of the flash. */
static bool leaves_flash(const struct operation *operation) {
    bool jumps = operation->kind >= OP_BRBS && operation->kind <= OP_CALL;
    return jumps && (uint32_t)operation->k >= board.avr->codeend;
}

void instructions_decode(void) {
    uint32_t words = (board.avr->flashend + 1) / 2;
    /* Two more (OP_SIMULATOR is 0): the simulator handles a program that runs past the end of the flash. */
    if (!operations) operations = calloc(words + 2, sizeof *operations);
    if (!operations) abort();
    for (uint32_t word = 0; word < words; word++) {
        struct operation operation = decode(word * 2);
        bool is_known = word * 2 + 2 <= board.avr->codeend && !leaves_flash(&operation);
        operations[word] = is_known ? operation : make(OP_SIMULATOR, 0, 0, 0);
    }
}

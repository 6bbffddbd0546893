/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Runs the common instructions several times as fast as the simulator: those on registers, RAM and flash only. The
 * simulator runs rare instructions, and accesses to peripherals or to addresses without memory. The tests compare the
 * results of each opcode with those of the simulator: registers, RAM, flags, program counter and cycles.
 */
#include "instructions.h"

#include "arithmetic.h"

uint32_t instructions_jumped_from;

#define PC ((uint32_t)(op - operations) * 2)
#define AS_LABEL(name) &&do_##name,

bool instructions_run(uint64_t limit) {
    static const void *const labels[] = {OPERATIONS(AS_LABEL)};
    avr_t *const avr = board.avr;
    uint8_t *const data = avr->data, *const flags = avr->sreg;
    const uint8_t *const flash = avr->flash;
    const uint32_t ram = avr->ioend + 1u, ram_size = avr->ramend - avr->ioend, flash_end = avr->flashend;
    const unsigned address_bytes = avr->address_size;
    const struct operation *op = operations + (avr->pc >> 1), *from = op;
    uint64_t cycle = avr->cycle;
    bool done = true;

    /* If an interrupt is pending, run only one instruction. */
    if (avr->interrupt_state) limit = 0;
    goto *labels[op->kind];

do_NOP:
    NEXT(1, 1);
do_MOVW:
    data[op->d] = data[op->r];
    data[op->d + 1] = data[op->r + 1];
    NEXT(1, 1);
do_ADD:
    data[op->d] = add(flags, data[op->d], data[op->r], 0);
    NEXT(1, 1);
do_ADC:
    data[op->d] = add(flags, data[op->d], data[op->r], flags[S_C]);
    NEXT(1, 1);
do_SUB:
    data[op->d] = subtract(flags, data[op->d], data[op->r], 0, false);
    NEXT(1, 1);
do_SBC:
    data[op->d] = subtract(flags, data[op->d], data[op->r], flags[S_C], true);
    NEXT(1, 1);
do_SUBI:
    data[op->d] = subtract(flags, data[op->d], (uint8_t)op->k, 0, false);
    NEXT(1, 1);
do_SBCI:
    data[op->d] = subtract(flags, data[op->d], (uint8_t)op->k, flags[S_C], true);
    NEXT(1, 1);
do_CP:
    subtract(flags, data[op->d], data[op->r], 0, false);
    NEXT(1, 1);
do_CPC:
    subtract(flags, data[op->d], data[op->r], flags[S_C], true);
    NEXT(1, 1);
do_CPI:
    subtract(flags, data[op->d], (uint8_t)op->k, 0, false);
    NEXT(1, 1);
do_AND:
    LOGIC(data[op->d] & data[op->r]);
do_OR:
    LOGIC(data[op->d] | data[op->r]);
do_EOR:
    LOGIC(data[op->d] ^ data[op->r]);
do_ANDI:
    LOGIC(data[op->d] & op->k);
do_ORI:
    LOGIC(data[op->d] | op->k);
do_MOV:
    data[op->d] = data[op->r];
    NEXT(1, 1);
do_LDI:
    data[op->d] = (uint8_t)op->k;
    NEXT(1, 1);
do_COM:
    FLAG(C, 1);
    LOGIC(~data[op->d]);
do_NEG: {
    uint8_t value = data[op->d], result = (uint8_t)-value;
    data[op->d] = result;
    FLAG(H, (result | value) >> 3);
    FLAG(C, result != 0);
    FLAG(V, result == 0x80);
    FLAG(N, result >> 7);
    FLAG(Z, result == 0);
    FLAG(S, flags[S_N] ^ flags[S_V]);
    NEXT(1, 1);
}
do_SWAP:
    data[op->d] = (uint8_t)(data[op->d] >> 4 | data[op->d] << 4);
    NEXT(1, 1);
do_INC:
    data[op->d]++;
    FLAG(V, data[op->d] == 0x80);
    goto counted;
do_DEC:
    data[op->d]--;
    FLAG(V, data[op->d] == 0x7f);
counted:
    FLAG(N, data[op->d] >> 7);
    FLAG(Z, data[op->d] == 0);
    FLAG(S, flags[S_N] ^ flags[S_V]);
    NEXT(1, 1);
do_ASR:
    data[op->d] = shifted(flags, data[op->d], (uint8_t)(data[op->d] >> 1 | (data[op->d] & 0x80)));
    NEXT(1, 1);
do_LSR:
    data[op->d] = shifted(flags, data[op->d], data[op->d] >> 1);
    NEXT(1, 1);
do_ROR:
    data[op->d] = shifted(flags, data[op->d], (uint8_t)(data[op->d] >> 1 | flags[S_C] << 7));
    NEXT(1, 1);
do_ADIW: {
    uint16_t value = word(data + op->d), result = (uint16_t)(value + op->k);
    put_word(data + op->d, result);
    FLAG(V, (~value & result) >> 15);
    FLAG(C, (~result & value) >> 15);
    FLAG(N, result >> 15);
    FLAG(Z, result == 0);
    FLAG(S, flags[S_N] ^ flags[S_V]);
    NEXT(1, 2);
}
do_SBIW: {
    uint16_t value = word(data + op->d), result = (uint16_t)(value - op->k);
    put_word(data + op->d, result);
    FLAG(V, (value & ~result) >> 15);
    FLAG(C, (result & ~value) >> 15);
    FLAG(N, result >> 15);
    FLAG(Z, result == 0);
    FLAG(S, flags[S_N] ^ flags[S_V]);
    NEXT(1, 2);
}
do_MUL: {
    uint16_t result = (uint16_t)(data[op->d] * data[op->r]);
    put_word(data, result);
    FLAG(Z, result == 0);
    FLAG(C, result >> 15);
    NEXT(1, 2);
}
do_BSET:
    avr_sreg_set(avr, op->d, 1);
    if (avr->interrupt_state) limit = 0;
    NEXT(1, 1);
do_BCLR:
    avr_sreg_set(avr, op->d, 0);
    NEXT(1, 1);
do_BST:
    FLAG(T, data[op->d] >> op->r);
    NEXT(1, 1);
do_BLD:
    data[op->d] = (uint8_t)((data[op->d] & ~(1 << op->r)) | flags[S_T] << op->r);
    NEXT(1, 1);

do_CPSE:
    SKIP_IF(data[op->d] == data[op->r]);
do_SBRC:
    SKIP_IF(!(data[op->d] >> op->r & 1));
do_SBRS:
    SKIP_IF(data[op->d] >> op->r & 1);
do_SBIC:
    if (avr->io[op->d].irq) goto simulator;
    if (avr->io[op->d].r.c) ASK_PERIPHERAL();
    SKIP_IF(!(data[op->d + 32] >> op->r & 1));
do_SBIS:
    if (avr->io[op->d].irq) goto simulator;
    if (avr->io[op->d].r.c) ASK_PERIPHERAL();
    SKIP_IF(data[op->d + 32] >> op->r & 1);
do_BRBS:
    if (flags[op->d]) JUMP(op->k, 2);
    NEXT(1, 1);
do_BRBC:
    if (!flags[op->d]) JUMP(op->k, 2);
    NEXT(1, 1);

do_IN:
    if (op->r == R_SREG - 32 || avr->io[op->r].r.c || avr->io[op->r].irq) {
        uint8_t value = 0;
        if (op->r != R_SREG - 32) goto simulator;
        for (int i = 0; i < 8; i++) value |= (uint8_t)(flags[i] << i);
        data[R_SREG] = data[op->d] = value;
    } else {
        data[op->d] = data[op->r + 32];
    }
    NEXT(1, 1);
do_OUT:
    if (op->r == R_SREG - 32) {
        uint8_t value = data[op->d];
        for (int i = 0; i < 8; i++) avr_sreg_set(avr, (uint8_t)i, value >> i & 1);
        data[R_SREG] = value;
        if (avr->interrupt_state) limit = 0;
    } else if (avr->io[op->r].w.c || avr->io[op->r].irq) {
        goto simulator;
    } else {
        data[op->r + 32] = data[op->d];
    }
    NEXT(1, 1);

do_LDS:
    NEEDS_RAM(op->k);
    data[op->d] = data[op->k];
    NEXT(2, 2);
do_STS:
    NEEDS_RAM(op->k);
    data[op->k] = data[op->d];
    NEXT(2, 2);
do_LDD: {
    uint16_t address = (uint16_t)(word(data + op->r) + op->k);
    NEEDS_RAM(address);
    data[op->d] = data[address];
    NEXT(1, 2);
}
do_STD: {
    uint16_t address = (uint16_t)(word(data + op->r) + op->k);
    NEEDS_RAM(address);
    data[address] = data[op->d];
    NEXT(1, 2);
}
do_LD_INC: {
    uint16_t address = word(data + op->r);
    NEEDS_RAM(address);
    put_word(data + op->r, address + 1);
    data[op->d] = data[address];
    NEXT(1, 2);
}
do_LD_DEC: {
    uint16_t address = (uint16_t)(word(data + op->r) - 1);
    NEEDS_RAM(address);
    put_word(data + op->r, address);
    data[op->d] = data[address];
    NEXT(1, 2);
}
do_ST_INC: {
    uint16_t address = word(data + op->r);
    NEEDS_RAM(address);
    data[address] = data[op->d];
    put_word(data + op->r, address + 1);
    NEXT(1, 2);
}
do_ST_DEC: {
    uint16_t address = (uint16_t)(word(data + op->r) - 1);
    NEEDS_RAM(address);
    data[address] = data[op->d];
    put_word(data + op->r, address);
    NEXT(1, 2);
}
do_LPM: {
    uint16_t address = word(data + 30);
    if (address > flash_end) goto simulator;
    data[op->d] = flash[address];
    NEXT(1, 3);
}
do_LPM_INC: {
    uint16_t address = word(data + 30);
    if (address > flash_end) goto simulator;
    data[op->d] = flash[address];
    put_word(data + 30, address + 1);
    NEXT(1, 3);
}
do_PUSH: {
    NEEDS_STACK(0, 1);
    data[sp] = data[op->d];
    put_word(data + R_SPL, (uint16_t)(sp - 1));
    NEXT(1, 2);
}
do_POP: {
    NEEDS_STACK(1, 0);
    data[op->d] = data[sp + 1];
    put_word(data + R_SPL, (uint16_t)(sp + 1));
    NEXT(1, 2);
}

do_JMP_NEAR:
    JUMP(op->k, 2);
do_JMP:
    JUMP(op->k, 3);
do_IJMP: {
    uint32_t target = (uint32_t)word(data + 30) << 1;
    if (target > flash_end) goto simulator;
    JUMP(target, 2);
}
do_RCALL: {
    NEEDS_STACK(0, address_bytes);
    push_address(data, sp, PC + 2, address_bytes);
    JUMP(op->k, address_bytes + 1);
}
do_CALL: {
    NEEDS_STACK(0, address_bytes);
    push_address(data, sp, PC + 4, address_bytes);
    JUMP(op->k, address_bytes + 2);
}
do_ICALL: {
    NEEDS_STACK(0, address_bytes);
    uint32_t target = (uint32_t)word(data + 30) << 1;
    if (target > flash_end) goto simulator;
    push_address(data, sp, PC + 2, address_bytes);
    JUMP(target, address_bytes + 1);
}
do_RET: {
    NEEDS_STACK(address_bytes, 0);
    uint32_t target = 0;
    for (unsigned i = 1; i <= address_bytes; i++) target = target << 8 | data[sp + i];
    if (target << 1 > flash_end) goto simulator;
    put_word(data + R_SPL, (uint16_t)(sp + address_bytes));
    JUMP(target << 1, address_bytes + 2);
}

restarted:
    instructions_jumped_from = (uint32_t)(from - operations) * 2;
    goto out;
do_SIMULATOR:
simulator:
    done = false;
out:
    avr->cycle = cycle;
    avr->pc = PC;
    return done;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The operations that decode.c creates and instructions.c runs. */
#ifndef INSTRUCTIONS_H
#define INSTRUCTIONS_H

#include <stdbool.h>
#include <stdint.h>

/* The order matters: BRBS to CALL are the operations whose target is a constant. */
#define OPERATIONS(_)                                                                                        \
    _(SIMULATOR) _(NOP) _(MOVW) _(CPC) _(SBC) _(ADD) _(CPSE) _(CP) _(SUB) _(ADC) _(AND) _(EOR) _(OR) _(MOV)  \
    _(CPI) _(SBCI) _(SUBI) _(ORI) _(ANDI) _(LDI) _(LDD) _(STD) _(LDS) _(STS) _(PUSH) _(POP) _(LPM)           \
    _(LPM_INC) _(LD_INC) _(LD_DEC) _(ST_INC) _(ST_DEC) _(COM) _(NEG) _(SWAP) _(INC) _(ASR) _(LSR) _(ROR)     \
    _(DEC) _(BSET) _(BCLR) _(ADIW) _(SBIW) _(SBIC) _(SBIS) _(MUL) _(BLD) _(BST) _(SBRC) _(SBRS) _(IN)        \
    _(OUT) _(RET) _(IJMP) _(ICALL) _(BRBS) _(BRBC) _(JMP_NEAR) _(RCALL) _(JMP) _(CALL)

#define AS_KIND(name) OP_##name,
enum operation_kind { OPERATIONS(AS_KIND) };

struct operation {
    uint8_t kind;
    uint8_t d; /* destination register, or the bit of a flag */
    uint8_t r; /* source or pointer register, port, or the bit of a register */
    int32_t k; /* constant, address, displacement, target, or the bytes to skip */
};

extern struct operation *operations;

void instructions_decode(void);

/*
 * Runs common instructions until the cycle `limit`, an interrupt or a jump to address 0. Returns false if the simulator
 * must run the next instruction.
 */
bool instructions_run(uint64_t limit);

/* The origin of the jump to address 0. */
extern uint32_t instructions_jumped_from;

#endif

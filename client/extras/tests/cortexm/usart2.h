// USART2 and SysTick of an STM32F405, for the kits' functions in this folder.
#ifndef USART2_H_
#define USART2_H_

#include "registers.h"

namespace usart2 {

const uint32_t BASE = 0x40004400;
enum Register { STATUS = 0x00, DATA = 0x04, BAUD_RATE = 0x08, CONTROL = 0x0c };
// The flags of the status register. The same bits of the control register enable their interrupts.
enum Flag { RECEIVED = 0x20, TRANSMIT_EMPTY = 0x80 };
enum Control { RECEIVER = 0x04, TRANSMITTER = 0x08, ENABLE = 0x2000 };

const uint32_t CLOCK_HZ = 168000000;
const uint32_t BUS_HZ = CLOCK_HZ / 4;
const uint32_t CLOCK_GATES = 0x40023840;
const uint32_t CLOCK_GATE = 1u << 17;
const uint32_t INTERRUPT = 38;
const uint32_t INTERRUPT_ENABLE = 0xe000e100 + INTERRUPT / 32 * 4;
const uint32_t INTERRUPT_PEND = 0xe000e200 + INTERRUPT / 32 * 4;
const uint32_t SYSTICK_CONTROL = 0xe000e010;
const uint32_t SYSTICK_RELOAD = 0xe000e014;
const uint32_t TICK_CLOCKS = CLOCK_HZ / 1000;

inline void setBaud(uint32_t baud) { at(BASE + BAUD_RATE) = BUS_HZ / baud; }

// Starts both: calls `tick` every millisecond, and `interrupt` for the flags with an enabled interrupt.
inline void start(void (*tick)(), void (*interrupt)(), uint32_t baud) {
  tick_handler = tick;
  uart_handler = interrupt;
  at(SYSTICK_RELOAD) = TICK_CLOCKS - 1;
  at(SYSTICK_CONTROL) = 7;
  at(CLOCK_GATES) |= CLOCK_GATE;
  setBaud(baud);
  at(BASE + CONTROL) = ENABLE | RECEIVER | TRANSMITTER;
  at(INTERRUPT_ENABLE) = 1u << INTERRUPT % 32;
}

inline bool isSet(Flag flag) { return at(BASE + STATUS) & flag; }
inline void letInterrupt(Flag flag) { at(BASE + CONTROL) |= flag; }
inline void keepQuiet(Flag flag) { at(BASE + CONTROL) &= ~flag; }
inline bool interrupts(Flag flag) { return at(BASE + STATUS) & at(BASE + CONTROL) & flag; }

}  // namespace usart2

#endif

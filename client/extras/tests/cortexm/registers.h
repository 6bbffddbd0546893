#ifndef REGISTERS_H_
#define REGISTERS_H_

#include <stdint.h>

inline volatile uint32_t& at(uint32_t address) { return *reinterpret_cast<volatile uint32_t*>(address); }

// The handlers of the interrupts of SysTick and of the UART.
extern void (*tick_handler)();
extern void (*uart_handler)();

#endif

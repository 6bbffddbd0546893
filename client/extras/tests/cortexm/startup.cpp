// The vectors and the start of a program on a Cortex-M: an STM32, or an LM3S6965, a predecessor of the Tiva C with the
// same UART.
#include <stdint.h>
#include <string.h>

#include "registers.h"

extern "C" {
extern uint8_t data_load[], data_start[], data_end[], bss_start[], bss_end[];
extern uint8_t stack_top[];
typedef void (*Constructor)();
extern Constructor __init_array_start[], __init_array_end[];

void startProgram();
// A guard for programs without threads: newlib's guard would link locks.
int __cxa_guard_acquire(uint8_t* guard) { return !*guard; }
void __cxa_guard_release(uint8_t* guard) { *guard = 1; }
int __aeabi_atexit(void*, void (*)(void*), void*) { return 0; }
void* __dso_handle = nullptr;
}

int main();

// After a fault the board is silent; a debugger shows the reason.
static void stop() {
  for (;;) {
  }
}

static void onTick() { tick_handler(); }
static void onUart() { uart_handler(); }

void (*tick_handler)() = stop;
void (*uart_handler)() = stop;

void startProgram() {
  memcpy(data_start, data_load, static_cast<size_t>(data_end - data_start));
  memset(bss_start, 0, static_cast<size_t>(bss_end - bss_start));
  for (Constructor* constructor = __init_array_start; constructor != __init_array_end; ++constructor) (*constructor)();
  main();
  stop();
}

typedef void (*Vector)();
// A UART is the only device with an interrupt, so all positions have its handler.
#define EIGHT onUart, onUart, onUart, onUart, onUart, onUart, onUart, onUart
__attribute__((section(".vectors"), used)) static const Vector vectors[] = {
    reinterpret_cast<Vector>(stack_top), startProgram, stop, stop, stop, stop, stop,
    nullptr, nullptr, nullptr, nullptr, stop, stop, nullptr, stop, onTick,
    EIGHT, EIGHT, EIGHT, EIGHT, EIGHT,
};

// The functions of TivaWare's driver library that platform/tivac.h calls, for the registers of an LM3S6965.
extern "C" {
#include <driverlib/driverlib.h>
}

#include "registers.h"

namespace {

enum Uart { DATA = 0x00, FLAGS = 0x18, INTEGER_RATE = 0x24, FRACTION_RATE = 0x28, LINE = 0x2c, CONTROL = 0x30,
            MASK = 0x38, RAW_STATUS = 0x3c, MASKED_STATUS = 0x40, CLEAR = 0x44 };
enum Flag { RECEIVE_EMPTY = 0x10, TRANSMIT_FULL = 0x20 };

const uint32_t SYSTICK_CONTROL = 0xe000e010;
const uint32_t SYSTICK_RELOAD = 0xe000e014;
const uint32_t INTERRUPT_ENABLE = 0xe000e100;
const uint32_t INTERRUPT_DISABLE = 0xe000e180;
const uint32_t CLOCK_GATES = 0x400fe104;
const uint32_t PORT_GATES = 0x400fe108;
const uint32_t PORT_FUNCTION = 0x420;
const uint32_t PORT_DIGITAL = 0x51c;
const uint32_t FIRST_INTERRUPT = 16;

}  // namespace

extern "C" {

void GPIOPinConfigure(uint32_t) {}
void GPIOPinTypeUART(uint32_t port, uint8_t pins) {
  at(port + PORT_FUNCTION) |= pins;
  at(port + PORT_DIGITAL) |= pins;
}
void IntEnable(uint32_t interrupt) { at(INTERRUPT_ENABLE) = 1u << (interrupt - FIRST_INTERRUPT); }
void IntDisable(uint32_t interrupt) { at(INTERRUPT_DISABLE) = 1u << (interrupt - FIRST_INTERRUPT); }
bool IntMasterEnable(void) {
  __asm__ volatile("cpsie i");
  return false;
}

// The clock after a reset: 200 MHz divided by 16.
uint32_t SysCtlClockGet(void) { return 12500000; }
void SysCtlPeripheralEnable(uint32_t peripheral) {
  at(peripheral == SYSCTL_PERIPH_UART0 ? CLOCK_GATES : PORT_GATES) |= 1;
}
bool SysCtlPeripheralReady(uint32_t) { return true; }

void SysTickEnable(void) { at(SYSTICK_CONTROL) |= 5; }
// Uses the processor's clock, which is the only one.
void SysTickIntEnable(void) { at(SYSTICK_CONTROL) |= 6; }
void SysTickIntRegister(void (*handler)(void)) { tick_handler = handler; }
void SysTickPeriodSet(uint32_t period) { at(SYSTICK_RELOAD) = period - 1; }

bool UARTCharsAvail(uint32_t base) { return !(at(base + FLAGS) & RECEIVE_EMPTY); }
bool UARTSpaceAvail(uint32_t base) { return !(at(base + FLAGS) & TRANSMIT_FULL); }
int32_t UARTCharGetNonBlocking(uint32_t base) {
  return UARTCharsAvail(base) ? static_cast<int32_t>(at(base + DATA) & 0xff) : -1;
}
bool UARTCharPutNonBlocking(uint32_t base, unsigned char data) {
  if (!UARTSpaceAvail(base)) return false;
  at(base + DATA) = data;
  return true;
}
void UARTConfigSetExpClk(uint32_t base, uint32_t clock, uint32_t baud, uint32_t config) {
  const uint32_t divisor = (clock * 8 / baud + 1) / 2;
  at(base + CONTROL) = 0;
  at(base + INTEGER_RATE) = divisor / 64;
  at(base + FRACTION_RATE) = divisor % 64;
  at(base + LINE) = config;
  at(base + CONTROL) = 0x301;
}
void UARTFIFOEnable(uint32_t base) { at(base + LINE) |= 0x10; }
void UARTIntClear(uint32_t base, uint32_t flags) { at(base + CLEAR) = flags; }
void UARTIntEnable(uint32_t base, uint32_t flags) { at(base + MASK) |= flags; }
void UARTIntRegister(uint32_t, void (*handler)(void)) { uart_handler = handler; }
uint32_t UARTIntStatus(uint32_t base, bool masked) { return at(base + (masked ? MASKED_STATUS : RAW_STATUS)); }
}

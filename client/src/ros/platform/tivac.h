// Tiva C boards (TM4C123, TM4C129) with TivaWare: UART0, which is the debugger's port, and SysTick for the time.
// With Energia, these boards are Arduinos and use platform/arduino.h.
//
// The program may define ROSSERIAL_BAUDRATE, RX_BUFFER_SIZE and TX_BUFFER_SIZE (powers of two) before <ros.h>. For a
// TM4C129 it must define TM4C129FREQ, the frequency to which it has set the processor's clock.
#ifndef ROS_PLATFORM_TIVAC_H_
#define ROS_PLATFORM_TIVAC_H_

#include <stdbool.h>
#include <stdint.h>

extern "C" {
#include <driverlib/gpio.h>
#include <driverlib/interrupt.h>
#include <driverlib/pin_map.h>
#include <driverlib/rom.h>
#include <driverlib/rom_map.h>
#include <driverlib/sysctl.h>
#include <driverlib/systick.h>
#include <driverlib/uart.h>
#include <inc/hw_ints.h>
#include <inc/hw_memmap.h>
}

#include "ros/platform/byte_ring.h"

#if !defined(ROSSERIAL_BAUDRATE)
#define ROSSERIAL_BAUDRATE 57600
#endif
#if !defined(RX_BUFFER_SIZE)
#define RX_BUFFER_SIZE 512
#endif
#if !defined(TX_BUFFER_SIZE)
#define TX_BUFFER_SIZE 512
#endif

class TivaCHardware {
 public:
  TivaCHardware() : baud_(ROSSERIAL_BAUDRATE) {}

  // Takes effect with the next initNode.
  void setBaud(long baud) { baud_ = static_cast<uint32_t>(baud); }
  long getBaud() const { return static_cast<long>(baud_); }

  void init() {
    SysTickIntRegister(&onTick);
    MAP_SysTickPeriodSet(getSysClkFreq() / 1000);
    MAP_SysTickIntEnable();
    MAP_SysTickEnable();

    MAP_SysCtlPeripheralEnable(SYSCTL_PERIPH_UART0);
    MAP_SysCtlPeripheralEnable(SYSCTL_PERIPH_GPIOA);
    while (!MAP_SysCtlPeripheralReady(SYSCTL_PERIPH_UART0) || !MAP_SysCtlPeripheralReady(SYSCTL_PERIPH_GPIOA)) {
    }
    MAP_GPIOPinConfigure(GPIO_PA0_U0RX);
    MAP_GPIOPinConfigure(GPIO_PA1_U0TX);
    MAP_GPIOPinTypeUART(GPIO_PORTA_BASE, GPIO_PIN_0 | GPIO_PIN_1);
    MAP_UARTConfigSetExpClk(UART0_BASE, getSysClkFreq(), baud_,
                            UART_CONFIG_WLEN_8 | UART_CONFIG_STOP_ONE | UART_CONFIG_PAR_NONE);
    MAP_UARTFIFOEnable(UART0_BASE);
    UARTIntRegister(UART0_BASE, &onUart);
    // RT is the interrupt for received bytes that wait because they do not reach the FIFO's limit.
    MAP_UARTIntEnable(UART0_BASE, UART_INT_RX | UART_INT_RT | UART_INT_TX);
    MAP_IntEnable(INT_UART0);
    MAP_IntMasterEnable();
  }

  int read() { return state().received.take(); }
  int writable() { return state().unsent.room(); }
  void write(uint8_t* bytes, int count) {
    for (int i = 0; i < count; ++i) {
      while (!writable()) {
      }
      state().unsent.put(bytes[i]);
    }
    // The interrupt also reads from the ring.
    MAP_IntDisable(INT_UART0);
    transmit();
    MAP_IntEnable(INT_UART0);
  }
  // Milliseconds since initNode.
  uint32_t time() { return state().time_ms; }

  static uint32_t getSysClkFreq() {
#if defined(TM4C129FREQ)
    return TM4C129FREQ;
#elif defined(TARGET_IS_TM4C129_RA0) || defined(TARGET_IS_TM4C129_RA1) || defined(TARGET_IS_TM4C129_RA2)
#error "define TM4C129FREQ, the frequency of the system clock that the program sets"
#else
    return MAP_SysCtlClockGet();
#endif
  }

  void delay(uint32_t wait_ms) {
    const uint32_t began_ms = time();
    while (time() - began_ms < wait_ms) {
    }
  }

 private:
  // One state for the program: interrupt handlers have no object.
  struct State {
    ros::ByteRing<RX_BUFFER_SIZE> received;
    ros::ByteRing<TX_BUFFER_SIZE> unsent;
    volatile uint32_t time_ms;
  };
  static State& state() {
    static State state;
    return state;
  }

  static void onTick() { state().time_ms = state().time_ms + 1; }

  static void onUart() {
    MAP_UARTIntClear(UART0_BASE, MAP_UARTIntStatus(UART0_BASE, true));
    while (MAP_UARTCharsAvail(UART0_BASE)) state().received.put(static_cast<uint8_t>(MAP_UARTCharGetNonBlocking(UART0_BASE)));
    transmit();
  }

  static void transmit() {
    while (state().unsent.count() && MAP_UARTSpaceAvail(UART0_BASE)) {
      MAP_UARTCharPutNonBlocking(UART0_BASE, static_cast<unsigned char>(state().unsent.take()));
    }
  }

  uint32_t baud_;
};

#endif

// The platforms' node as a program without an operating system.
#include "platform_node.h"

#if defined(USE_HAL_DRIVER)
extern "C" void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) { nh.getHardware()->flush(); }
extern "C" void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { nh.getHardware()->reset_rbuf(); }
#endif

// A processor that waits needs no simulation.
static void waitForInterrupt() { __asm__ volatile("wfi"); }

int main() {
  nh.initNode();
  setupNode();
  for (;;) {
    const unsigned long began_ms = nh.getHardware()->time();
    loopNode();
    while (nh.getHardware()->time() - began_ms < 5) waitForInterrupt();
  }
}

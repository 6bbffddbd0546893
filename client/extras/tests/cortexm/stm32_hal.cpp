// The functions of ST's HAL that platform/stm32_hal.h calls, for the registers of USART2 of an STM32F405, without DMA.
#include "main.h"
#include "usart2.h"

UART_HandleTypeDef huart2 = {nullptr, nullptr, HAL_UART_STATE_READY, HAL_UART_STATE_READY, HAL_UART_ERROR_NONE};

namespace {

volatile uint32_t ticks_ms = 0;
uint8_t* receive_to = nullptr;
const uint8_t* volatile send_from = nullptr;
volatile uint16_t send_count = 0;

void onTick() { ++ticks_ms; }

void onUsart() {
  if (usart2::interrupts(usart2::RECEIVED)) {
    *receive_to = static_cast<uint8_t>(at(usart2::BASE + usart2::DATA));
    usart2::keepQuiet(usart2::RECEIVED);
    huart2.RxState = HAL_UART_STATE_READY;
    HAL_UART_RxCpltCallback(&huart2);
  }
  while (send_count && usart2::interrupts(usart2::TRANSMIT_EMPTY)) {
    at(usart2::BASE + usart2::DATA) = *send_from;
    send_from = send_from + 1;
    send_count = send_count - 1;
    if (send_count) continue;
    usart2::keepQuiet(usart2::TRANSMIT_EMPTY);
    huart2.gState = HAL_UART_STATE_READY;
    HAL_UART_TxCpltCallback(&huart2);
  }
}

// The beginning of main() in a CubeMX project.
struct Start {
  Start() { usart2::start(onTick, onUsart, 57600); }
} start;

}  // namespace

extern "C" {

uint32_t HAL_GetTick(void) { return ticks_ms; }

HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef* huart, uint8_t* data, uint16_t) {
  if (huart->RxState != HAL_UART_STATE_READY) return HAL_BUSY;
  receive_to = data;
  huart->RxState = HAL_UART_STATE_RESET;
  usart2::letInterrupt(usart2::RECEIVED);
  return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef* huart, uint8_t* data, uint16_t size) {
  if (huart->gState != HAL_UART_STATE_READY) return HAL_BUSY;
  send_from = data;
  send_count = size;
  huart->gState = HAL_UART_STATE_RESET;
  usart2::letInterrupt(usart2::TRANSMIT_EMPTY);
  // qemu 7.2 does not raise the interrupt of an empty transmitter.
  at(usart2::INTERRUPT_PEND) = 1u << usart2::INTERRUPT % 32;
  return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_Receive_DMA(UART_HandleTypeDef*, uint8_t*, uint16_t) { return HAL_ERROR; }
HAL_StatusTypeDef HAL_UART_Transmit_DMA(UART_HandleTypeDef*, uint8_t*, uint16_t) { return HAL_ERROR; }

uint32_t __get_PRIMASK(void) {
  uint32_t mask;
  __asm__ volatile("mrs %0, primask" : "=r"(mask));
  return mask;
}
void __set_PRIMASK(uint32_t mask) { __asm__ volatile("msr primask, %0" : : "r"(mask) : "memory"); }
void __disable_irq(void) { __asm__ volatile("cpsid i" : : : "memory"); }
}

// The calls of ST's HAL that platform/stm32_hal.h makes, by the registers of USART2 of an STM32F405, without DMA.
#include "main.h"
#include "registers.h"

UART_HandleTypeDef huart2 = {nullptr, nullptr, HAL_UART_STATE_READY, HAL_UART_STATE_READY, HAL_UART_ERROR_NONE};

namespace {

const uint32_t USART2 = 0x40004400;
enum Register { STATUS = 0x00, DATA = 0x04, BAUD_RATE = 0x08, CONTROL = 0x0c };
enum Flag { RECEIVED = 0x20, SENT_ALL = 0x40, TRANSMIT_EMPTY = 0x80 };
// The interrupt of each flag has the flag's bit.
enum Control { RECEIVER = 0x04, TRANSMITTER = 0x08, ENABLE = 0x2000 };

const uint32_t CLOCK_HZ = 168000000;
const uint32_t BUS_HZ = CLOCK_HZ / 4;
const uint32_t BAUD = 57600;
const uint32_t CLOCK_GATES = 0x40023840;
const uint32_t USART2_GATE = 1u << 17;
const uint32_t INTERRUPT = 38;
const uint32_t INTERRUPT_ENABLE = 0xe000e100 + INTERRUPT / 32 * 4;
const uint32_t INTERRUPT_PEND = 0xe000e200 + INTERRUPT / 32 * 4;
const uint32_t SYSTICK_CONTROL = 0xe000e010;
const uint32_t SYSTICK_RELOAD = 0xe000e014;

volatile uint32_t ticks_ms = 0;
uint8_t* receive_to = nullptr;
const uint8_t* volatile send_from = nullptr;
volatile uint16_t send_count = 0;

void onTick() { ++ticks_ms; }

void onUsart() {
  if (at(USART2 + STATUS) & at(USART2 + CONTROL) & RECEIVED) {
    *receive_to = static_cast<uint8_t>(at(USART2 + DATA));
    at(USART2 + CONTROL) &= ~RECEIVED;
    huart2.RxState = HAL_UART_STATE_READY;
    HAL_UART_RxCpltCallback(&huart2);
  }
  while (send_count && at(USART2 + STATUS) & at(USART2 + CONTROL) & TRANSMIT_EMPTY) {
    at(USART2 + DATA) = *send_from;
    send_from = send_from + 1;
    send_count = send_count - 1;
    if (send_count) continue;
    at(USART2 + CONTROL) &= ~TRANSMIT_EMPTY;
    huart2.gState = HAL_UART_STATE_READY;
    HAL_UART_TxCpltCallback(&huart2);
  }
}

// What main() of a CubeMX project does first.
struct Start {
  Start() {
    tick_handler = onTick;
    uart_handler = onUsart;
    at(SYSTICK_RELOAD) = CLOCK_HZ / 1000 - 1;
    at(SYSTICK_CONTROL) = 7;
    at(CLOCK_GATES) |= USART2_GATE;
    at(USART2 + BAUD_RATE) = BUS_HZ / BAUD;
    at(USART2 + CONTROL) = ENABLE | RECEIVER | TRANSMITTER;
    at(INTERRUPT_ENABLE) = 1u << INTERRUPT % 32;
  }
} start;

}  // namespace

extern "C" {

uint32_t HAL_GetTick(void) { return ticks_ms; }

HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef* huart, uint8_t* data, uint16_t) {
  if (huart->RxState != HAL_UART_STATE_READY) return HAL_BUSY;
  receive_to = data;
  huart->RxState = HAL_UART_STATE_RESET;
  at(USART2 + CONTROL) |= RECEIVED;
  return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef* huart, uint8_t* data, uint16_t size) {
  if (huart->gState != HAL_UART_STATE_READY) return HAL_BUSY;
  send_from = data;
  send_count = size;
  huart->gState = HAL_UART_STATE_RESET;
  at(USART2 + CONTROL) |= TRANSMIT_EMPTY;
  // qemu 7.2 does not raise the interrupt of an empty transmitter.
  at(INTERRUPT_PEND) = 1u << INTERRUPT % 32;
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

// The part of ST's HAL that the library uses. In a CubeMX project, main.h includes the HAL.
#ifndef STUB_MAIN_H_
#define STUB_MAIN_H_

#include <stdint.h>

#define HAL_UART_ERROR_NONE 0x00000000U

typedef enum { HAL_OK, HAL_ERROR, HAL_BUSY, HAL_TIMEOUT } HAL_StatusTypeDef;
typedef enum { HAL_UART_STATE_RESET = 0x00, HAL_UART_STATE_READY = 0x20 } HAL_UART_StateTypeDef;

typedef struct {
  volatile uint32_t NDTR;
} DMA_Stream_TypeDef;
typedef struct {
  DMA_Stream_TypeDef* Instance;
} DMA_HandleTypeDef;
typedef struct {
  DMA_HandleTypeDef* hdmatx;
  DMA_HandleTypeDef* hdmarx;
  volatile HAL_UART_StateTypeDef gState;
  volatile HAL_UART_StateTypeDef RxState;
  volatile uint32_t ErrorCode;
} UART_HandleTypeDef;

#define __HAL_DMA_GET_COUNTER(handle) ((handle)->Instance->NDTR)

extern "C" {
uint32_t HAL_GetTick(void);
HAL_StatusTypeDef HAL_UART_Receive_DMA(UART_HandleTypeDef* huart, uint8_t* data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef* huart, uint8_t* data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Transmit_DMA(UART_HandleTypeDef* huart, uint8_t* data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef* huart, uint8_t* data, uint16_t size);
void HAL_UART_TxCpltCallback(UART_HandleTypeDef* huart);
void HAL_UART_RxCpltCallback(UART_HandleTypeDef* huart);
uint32_t __get_PRIMASK(void);
void __set_PRIMASK(uint32_t mask);
void __disable_irq(void);
}

#endif

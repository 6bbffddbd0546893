// STM32 with ST's HAL (CubeMX, CubeIDE): a UART of the project, by default huart2. It uses DMA if that is configured.
//
// The project configures the baud rate, the UART's interrupt and preferably DMA: circular reception and normal
// transmission. The program forwards the callbacks of the HAL:
//
//   void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) { nh.getHardware()->flush(); }
//   void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) { nh.getHardware()->reset_rbuf(); }
//   void HAL_UART_ErrorCallback(UART_HandleTypeDef*) { nh.getHardware()->reset_rbuf(); }
//
// For another UART, derive a class from STM32Hardware that calls STM32Hardware(&huart3), and use it with
// ros::NodeHandle_.
#ifndef ROS_PLATFORM_STM32_HAL_H_
#define ROS_PLATFORM_STM32_HAL_H_

#include <stdint.h>

// Every CubeMX project has main.h, which includes the HAL of its family.
#if defined(ROS_STM32_HAL_HEADER)
#include ROS_STM32_HAL_HEADER
#else
#include "main.h"
#endif

extern UART_HandleTypeDef huart2;

class STM32Hardware {
 public:
  STM32Hardware() : huart(&huart2), rind(0), rhead(0), twind(0), tfind(0), tcount(0) {}
  explicit STM32Hardware(UART_HandleTypeDef* huart_) : huart(huart_), rind(0), rhead(0), twind(0), tfind(0), tcount(0) {}

  void init() {
    rind = rhead = 0;
    receive();
  }

  // Called after the HAL has received a byte without DMA, and after an error, which ends reception in both modes.
  void reset_rbuf() {
    if (!huart->hdmarx && huart->ErrorCode == HAL_UART_ERROR_NONE) rhead = (rhead + 1) & (rbuflen - 1);
    if (huart->RxState == HAL_UART_STATE_READY) {
      if (huart->hdmarx) rind = 0;
      receive();
    }
  }

  int read() {
    const uint16_t head = huart->hdmarx ? dmaHead() : rhead;
    if (rind == head) return -1;
    const uint8_t byte = rbuf[rind];
    rind = (rind + 1) & (rbuflen - 1);
    return byte;
  }

  int writable() {
    if (tfind != twind) flush();
    return room();
  }
  void write(uint8_t* bytes, int count) {
    for (int i = 0; i < count; ++i) {
      while (!room()) flush();
      tbuf[twind] = bytes[i];
      twind = (twind + 1) & (tbuflen - 1);
    }
    flush();
  }

  // Sends the buffered bytes, up to the end of the buffer, when the UART is ready.
  void flush() {
    const uint32_t were_masked = __get_PRIMASK();
    __disable_irq();
    if (huart->gState == HAL_UART_STATE_READY) {
      tfind = (tfind + tcount) & (tbuflen - 1);
      tcount = tfind <= twind ? twind - tfind : tbuflen - tfind;
      if (tcount) {
        uint8_t* from = tbuf + tfind;
        if ((huart->hdmatx ? HAL_UART_Transmit_DMA(huart, from, tcount) : HAL_UART_Transmit_IT(huart, from, tcount)) != HAL_OK) {
          tcount = 0;
        }
      }
    }
    __set_PRIMASK(were_masked);
  }

  unsigned long time() { return HAL_GetTick(); }

 protected:
  static const uint16_t rbuflen = 512;
  static const uint16_t tbuflen = 512;

  uint16_t room() const { return static_cast<uint16_t>(tfind - twind - 1) & (tbuflen - 1); }
  void receive() {
    if (huart->hdmarx) {
      HAL_UART_Receive_DMA(huart, rbuf, rbuflen);
    } else {
      HAL_UART_Receive_IT(huart, rbuf + rhead, 1);
    }
  }
  uint16_t dmaHead() { return static_cast<uint16_t>(rbuflen - __HAL_DMA_GET_COUNTER(huart->hdmarx)) & (rbuflen - 1); }

  UART_HandleTypeDef* huart;
  uint8_t rbuf[rbuflen];
  uint8_t tbuf[tbuflen];
  uint16_t rind;            // index of the next byte to read
  volatile uint16_t rhead;  // without DMA: index of the next received byte
  uint16_t twind;           // index of the next byte to write
  volatile uint16_t tfind;  // index of the first byte that is not sent yet
  volatile uint16_t tcount;  // number of bytes that are being sent
};

#endif

// The SPI of the OpenCR's IMU.
#ifndef OPENCR_ON_LINUX_SPI_H_
#define OPENCR_ON_LINUX_SPI_H_

#include <stdint.h>

#define SPI_MODE0 0
#define SPI_MODE3 3
#define MSBFIRST 1
#define SPI_CLOCK_DIV8 8
#define SPI_CLOCK_DIV128 128

class SPIClass {
 public:
  void begin() {}
  void setDataMode(uint8_t) {}
  void setBitOrder(int) {}
  void setClockDivider(uint8_t) {}
  uint8_t transfer(uint8_t sent);
};
extern SPIClass SPI_IMU;

#endif

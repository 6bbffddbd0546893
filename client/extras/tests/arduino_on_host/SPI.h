#ifndef SPI_ON_HOST_H_
#define SPI_ON_HOST_H_
#endif

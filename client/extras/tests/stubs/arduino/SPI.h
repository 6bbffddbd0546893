#ifndef STUB_SPI_H_
#define STUB_SPI_H_
#endif

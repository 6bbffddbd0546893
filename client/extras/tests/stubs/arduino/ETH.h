#ifndef STUB_ETH_H_
#define STUB_ETH_H_

#include <Arduino.h>

class ETHClass {
 public:
  IPAddress localIP();
};
extern ETHClass ETH;

#endif

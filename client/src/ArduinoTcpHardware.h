// Like <ArduinoHardware.h>, but uses the board's network instead of its serial port.
#if !defined(ROSSERIAL_ARDUINO_TCP)
#define ROSSERIAL_ARDUINO_TCP
#endif
#include "ros.h"

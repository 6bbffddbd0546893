// Constant text that stays in program memory.
//
// An AVR copies every ordinary constant into its 2 KiB of RAM at start. Type names and md5sums are only
// ever sent, so they stay in flash and are read byte by byte; on other boards flash is ordinary memory.
#ifndef ROS_FLASH_H_
#define ROS_FLASH_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVR__)
#include <avr/pgmspace.h>
#define ROS_FLASH PROGMEM
#define ROS_READ_FLASH(address) pgm_read_byte(address)
#define ROS_FLASH_LENGTH(text) strlen_P(text)
#define ROS_COPY_FLASH(to, from, count) memcpy_P(to, from, count)
#else
#define ROS_FLASH
#define ROS_READ_FLASH(address) (*(address))
#define ROS_FLASH_LENGTH(text) strlen(text)
#define ROS_COPY_FLASH(to, from, count) memcpy(to, from, count)
#endif

// Arduino's F("...") has this type on every board; on other systems nothing has it.
class __FlashStringHelper;

namespace ros {

// Address of a NUL-terminated text in program memory: not to be read as a plain pointer on an AVR.
struct FlashText {
  const char* address;
};

}  // namespace ros

#endif

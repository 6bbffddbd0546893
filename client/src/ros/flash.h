// Constant text that stays in program memory.
//
// An AVR copies every ordinary constant to its RAM (2 KiB on an Uno) at start. Type names and md5sums are only sent,
// so they stay in flash and are read byte by byte. On other boards, flash is ordinary memory.
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

// The type of Arduino's F("...") on every board; other systems do not define it.
class __FlashStringHelper;

namespace ros {

// The address of a NUL-terminated text in program memory, which an AVR cannot read through a plain pointer.
struct FlashText {
  const char* address;
};

}  // namespace ros

#endif

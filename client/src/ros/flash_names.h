#ifndef ROS_FLASH_NAMES_H_
#define ROS_FLASH_NAMES_H_

#include <stddef.h>

#include "ros/flash.h"
#include "ros/frame_writer.h"

namespace ros {

// Type and md5sum of a message in flash, each with its NUL, one behind the other: one address says both.
struct FlashNames {
  const char* both;

  size_t typeLength() const { return ROS_FLASH_LENGTH(both); }
  // Bytes of the two as strings on the wire.
  size_t length() const { return 4 + typeLength() + 4 + MD5_DIGITS; }
  void write(FrameWriter& writer) const {
    const size_t type_length = typeLength();
    writer.flashString(both, type_length);
    writer.flashString(both + type_length + 1, MD5_DIGITS);
  }

 private:
  static const uint8_t MD5_DIGITS = 32;
};

}  // namespace ros

#endif

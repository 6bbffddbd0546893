#ifndef ROS_FLASH_NAMES_H_
#define ROS_FLASH_NAMES_H_

#include <stddef.h>

#include "flash.h"
#include "frame_writer.h"

namespace ros {

// Type and md5sum of a message in flash, each with its NUL, one behind the other: one address says both.
struct FlashNames {
  const char* both;

  // Bytes of the two as strings on the wire; an md5sum is 32 digits.
  size_t length() const { return 4 + ROS_FLASH_LENGTH(both) + 4 + 32; }
  void write(FrameWriter& writer) const {
    FlashText text = {both};
    writer.string(text);
    text.address += ROS_FLASH_LENGTH(both) + 1;
    writer.string(text);
  }
};

}  // namespace ros

#endif

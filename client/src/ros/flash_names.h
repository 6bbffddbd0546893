#ifndef ROS_FLASH_NAMES_H_
#define ROS_FLASH_NAMES_H_

#include <stddef.h>

#include "ros/flash.h"
#include "ros/frame_writer.h"

namespace ros {

// Type and md5sum of a message in flash: the type, then the length of the md5sum and the md5sum as on the wire.
class FlashNames {
 public:
  constexpr FlashNames(const char* both, uint8_t type_length) : both_(both), type_length_(type_length) {}

  // The bytes of both as strings on the wire.
  size_t length() const { return static_cast<size_t>(4 + afterPrefix()); }
  void write(FrameWriter& writer) const {
    writer.count(type_length_);
    writer.putFlash(both_, afterPrefix());
  }

 private:
  static const uint8_t MD5_BYTES = 4 + 32;

  uint16_t afterPrefix() const { return static_cast<uint16_t>(type_length_ + MD5_BYTES); }

  const char* both_;
  uint8_t type_length_;
};

}  // namespace ros

#endif

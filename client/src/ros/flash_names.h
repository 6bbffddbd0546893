#ifndef ROS_FLASH_NAMES_H_
#define ROS_FLASH_NAMES_H_

#include <stddef.h>
#include <stdint.h>

#include "ros/flash.h"
#include "ros/frame_writer.h"

namespace ros {

// The type and md5sum of a message in flash, stored as the length of the type in one byte, the type, and the md5sum in
// its form on the wire (with a length of four bytes).
class FlashNames {
 public:
  explicit constexpr FlashNames(const uint8_t* names) : names_(names) {}

  // The number of bytes that both texts take on the wire.
  size_t length() const { return static_cast<size_t>(4 + typeLength() + MD5_BYTES); }
  void write(FrameWriter& writer) const {
    writer.count(typeLength());
    writer.putFlash(reinterpret_cast<const char*>(names_ + 1), static_cast<uint16_t>(typeLength() + MD5_BYTES));
  }

 private:
  static const uint8_t MD5_BYTES = 4 + 32;

  uint8_t typeLength() const { return ROS_READ_FLASH(names_); }

  const uint8_t* names_;
};

}  // namespace ros

#endif

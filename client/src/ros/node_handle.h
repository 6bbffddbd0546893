#ifndef ROS_NODE_HANDLE_H_
#define ROS_NODE_HANDLE_H_

#include <stddef.h>
#include <stdint.h>

// A sketch with its own Hardware may include this header alone.
#include "ros/node_handle_base.h"
#include "ros/parameters.h"
#include "ros/publisher.h"
#include "ros/service_client.h"
#include "ros/service_server.h"
#include "ros/subscriber.h"

namespace ros {

// A node on a Hardware, which is a class with these functions:
//   void init()                              opens the line
//   int read()                               returns a received byte, or less than 0 if there is none
//   void write(uint8_t* bytes, int count)    sends bytes
//   unsigned long time()                     returns the time in milliseconds
//
// These functions are optional:
//   int writable()      Returns the number of bytes that write accepts at once. With it, the node never waits: while
//                       the transmitter is full, it continues to read.
//   bool relinked()     For a Hardware that reconnects by itself: returns whether the link was lost or replaced since
//                       the last call. Between this change and the call, the Hardware must not send or receive bytes.
//                       After the call, the node introduces itself again.
//   void relink()       Together with relinked(): makes a new link. The node calls it when the host is silent for about
//                       10 s, because a network can fail without ending the connection.
//   bool isReliable()   Returns whether a connection loses no byte, like TCP. Then the node waits longer for the rest
//                       of a frame.
//
// INPUT_SIZE is the length of the longest message that can be received. The other sizes have no effect: the number of
// publishers and subscribers is not limited, and messages are sent without a buffer.
template <class Hardware, int MAX_SUBSCRIBERS = 25, int MAX_PUBLISHERS = 25, int INPUT_SIZE = 512, int OUTPUT_SIZE = 512>
class NodeHandle_ : public NodeHandleBase_ {
 public:
  // At least a time, and a request for the topics, must fit.
  static const uint16_t INPUT_BYTES = INPUT_SIZE < 16 ? 16 : INPUT_SIZE;
  static_assert(INPUT_SIZE <= 0xffff - FRAME_OVERHEAD_BYTES, "no frame is longer than 65535 bytes");

  NodeHandle_() {}
  explicit NodeHandle_(const Hardware& hardware) : hardware_(hardware) {}

  Hardware* getHardware() { return &hardware_; }

  void initNode() {
    hardware_.init();
    start(buffer_, sizeof buffer_);
  }
  // For hardware that is opened by name: "/dev/ttyUSB0", "192.168.0.7:11411".
  template <class Port>
  void initNode(Port port) {
    hardware_.init(port);
    start(buffer_, sizeof buffer_);
  }

  int spinOnce() override {
    window_.release();
    if (window_.wantsMore()) {
      const uint16_t now_ms = milliseconds();
      const int byte = hardware_.read();
      if (byte >= 0) {
        window_.append(static_cast<uint8_t>(byte));
        received_ms_ = now_ms;
      } else {
        if (relinked(hardware_, 0)) {
          window_.forget();
          contactAgain();
        }
        if (isHostSilent()) relink(hardware_, 0);
        if (!isTorn(now_ms, isReliable(hardware_, 0))) return keepInTouch(now_ms);
        window_.giveUp();
      }
    }
    return spinOn();
  }

  uint32_t time() override { return static_cast<uint32_t>(hardware_.time()); }

 private:
  // If the transmitter accepts no byte for this time, the line is not connected: at 9600 baud, one byte takes 1 ms.
  static const uint16_t STALL_MS = 100;

  template <class H>
  static auto relinked(H& hardware, int) -> decltype(hardware.relinked()) {
    return hardware.relinked();
  }
  template <class H>
  static bool relinked(H&, long) {
    return false;
  }

  template <class H>
  static auto isReliable(H& hardware, int) -> decltype(hardware.isReliable()) {
    return hardware.isReliable();
  }
  template <class H>
  static bool isReliable(H&, long) {
    return false;
  }

  template <class H>
  static auto relink(H& hardware, int) -> decltype(hardware.relink()) {
    hardware.relink();
  }
  template <class H>
  static void relink(H&, long) {}

  // Handles received bytes. It is separate from spinOnce, which usually finds none: without this function's registers,
  // spinOnce is faster.
  ROS_NOINLINE int8_t spinOn() {
    const uint16_t began_ms = milliseconds();
    for (;;) {
      uint16_t now_ms = milliseconds();
      if (window_.wantsMore()) {
        if (window_.fill(hardware_)) received_ms_ = now_ms;
        if (window_.wantsMore()) return keepInTouch(now_ms);
      }
      const uint8_t found = window_.examine();
      if (found) {
        if (!handle(found)) return SPIN_OK;
        now_ms = milliseconds();
        if (isOverdue(began_ms, now_ms)) {
          keepInTouch(now_ms);
          return SPIN_TIMEOUT;
        }
      } else if (!window_.wantsMore()) {
        return SPIN_OK;
      }
    }
  }

  bool transmit(uint8_t* bytes, uint16_t count) override { return transmit(hardware_, bytes, count, 0); }

  // Continues to read while the transmitter is full.
  template <class H>
  auto transmit(H& hardware, uint8_t* bytes, uint16_t count, int) -> decltype(hardware.writable(), bool()) {
    uint16_t began_ms = milliseconds();
    for (;;) {
      uint16_t room = static_cast<uint16_t>(hardware.writable());
      if (room) {
        if (room > count) room = count;
        hardware.write(bytes, room);
        stalled_ = false;
        count = static_cast<uint16_t>(count - room);
        if (!count) return true;
        bytes += room;
        began_ms = milliseconds();
      } else {
        // After a stall, the next frame does not wait again.
        if (stalled_ || since(began_ms, milliseconds()) > STALL_MS) {
          stalled_ = true;
          window_.countDropped();
          return false;
        }
      }
      receive();
    }
  }
  template <class H>
  bool transmit(H& hardware, uint8_t* bytes, uint16_t count, long) {
    hardware.write(bytes, count);
    return true;
  }

  uint16_t milliseconds() { return static_cast<uint16_t>(hardware_.time()); }

  // The data of the last message stays valid while the sketch may read it.
  ROS_APART void receive() {
    while (!window_.held() && window_.room()) {
      const int byte = hardware_.read();
      if (byte < 0) return;
      window_.appendBacklog(static_cast<uint8_t>(byte));
      received_ms_ = milliseconds();
    }
  }

 protected:
  // Protected for the constructors of sketches' own node handle classes.
  Hardware hardware_;

 private:
  uint8_t buffer_[INPUT_BYTES + FRAME_OVERHEAD_BYTES];
};

}  // namespace ros

#endif

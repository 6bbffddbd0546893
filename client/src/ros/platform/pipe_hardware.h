#ifndef ROS_PLATFORM_PIPE_HARDWARE_H_
#define ROS_PLATFORM_PIPE_HARDWARE_H_

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "ros/platform/reconnection.h"

namespace ros {

enum PipeState { PIPE_FAILED, PIPE_PENDING, PIPE_OPEN };

// The hardware of a program on an operating system: bytes through a Pipe, which is opened again whenever it breaks.
// It never blocks.
//
// A Pipe has
//   PipeState open(uint32_t wait_ms)         starts or continues to open it, for about this time
//   int read(uint8_t* bytes, size_t size)    returns the number of bytes read; less than 0 if the pipe is broken
//   int write(const uint8_t* bytes, size_t)  returns the number of bytes written; less than 0 if the pipe is broken
//   void wait(uint32_t wait_ms)              waits until it can be read or written, but at most for this time
//   void close()                             closes it
//   bool isNetwork()                         returns whether the link can fail without an error
//   const char* name()                       returns the name of what it opens
//   const char* reason()                     returns why it could not be opened
//   static uint32_t milliseconds()           returns the time of a clock that is never adjusted
// A copy of a Pipe starts closed, even if the original is open.
template <class Pipe>
class PipeHardware {
 public:
  explicit PipeHardware(const Pipe& pipe) : pipe_(pipe), began_ms_(0), next_(0), filled_(0), unsent_(0), reported_(false) {}
  PipeHardware(const PipeHardware& other) : pipe_(other.pipe_), began_ms_(0), next_(0), filled_(0), unsent_(0), reported_(false) {}
  ~PipeHardware() { pipe_.close(); }
  PipeHardware& operator=(const PipeHardware&) = delete;

  Pipe& pipe() { return pipe_; }
  bool connected() const { return link_.isConnected(); }

  void init() {
    if (!began_ms_) began_ms_ = Pipe::milliseconds();
    shut();
    link_.reset();
    attempt(FIRST_WAIT_MS);
  }

  int read() {
    if (!link_.isOpen()) {
      if (link_.isDue(Pipe::milliseconds())) attempt(LATER_WAIT_MS);
      return -1;
    }
    if (next_ == filled_) {
      next_ = filled_ = 0;
      if (unsent_) flush();
      const int count = link_.isOpen() ? pipe_.read(input_, sizeof input_) : 0;
      if (count < 0) lose();
      if (count <= 0) return -1;
      filled_ = static_cast<size_t>(count);
    }
    return input_[next_++];
  }

  // Buffers bytes that the system does not accept yet. Without a link, it drops them.
  void write(const uint8_t* bytes, int count) {
    if (!link_.isOpen() || count <= 0) return;
    size_t length = static_cast<size_t>(count);
    if (length > sizeof output_ - unsent_) length = sizeof output_ - unsent_;
    memcpy(output_ + unsent_, bytes, length);
    unsent_ += length;
    flush();
  }
  int writable() {
    if (!link_.isOpen()) return static_cast<int>(sizeof output_);
    if (unsent_) flush();
    if (unsent_ == sizeof output_) {
      pipe_.wait(FULL_WAIT_MS);
      flush();
    }
    return static_cast<int>(sizeof output_ - unsent_);
  }

  bool relinked() { return link_.takeChange(); }
  // Reconnects to a silent host. A serial port stays open: the host's program may start at any time.
  void relink() {
    if (pipe_.isNetwork() && link_.isConnected()) lose();
  }
  bool isReliable() { return pipe_.isNetwork(); }
  // The time since the first initNode.
  unsigned long time() { return Pipe::milliseconds() - began_ms_; }

 private:
  // initNode waits for the host, but a spinOnce that reconnects must not delay the program.
  static const uint32_t FIRST_WAIT_MS = 1000;
  static const uint32_t LATER_WAIT_MS = 5;
  // A full output delays the node by at most this time before it checks for received bytes again.
  static const uint32_t FULL_WAIT_MS = 5;

  void attempt(uint32_t wait_ms) {
    const uint32_t began_ms = Pipe::milliseconds();
    const PipeState state = pipe_.open(wait_ms);
    if (state == PIPE_OPEN) {
      link_.succeeded();
      reported_ = false;
    } else if (state == PIPE_FAILED) {
      link_.failed(began_ms, Pipe::milliseconds());
      if (!reported_) fprintf(stderr, "ros_lib: %s: %s; trying again\n", pipe_.name(), pipe_.reason());
      reported_ = true;
    }
  }

  void flush() {
    const int count = pipe_.write(output_, unsent_);
    if (count < 0) {
      lose();
    } else if (count > 0) {
      unsent_ -= static_cast<size_t>(count);
      memmove(output_, output_ + count, unsent_);
    }
  }

  void lose() {
    shut();
    link_.lost(Pipe::milliseconds());
  }

  void shut() {
    pipe_.close();
    next_ = filled_ = unsent_ = 0;
  }

  Pipe pipe_;
  Reconnection link_;
  uint32_t began_ms_;
  size_t next_;
  size_t filled_;
  size_t unsent_;
  bool reported_;
  uint8_t input_[4096];
  uint8_t output_[4096];
};

}  // namespace ros

#endif

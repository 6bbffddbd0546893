// A serial port of any class. All ports of Arduino are Streams, but a Stream has no `begin`, and not every port
// reports its free buffer space.
#ifndef ROS_PLATFORM_SERIAL_PORT_H_
#define ROS_PLATFORM_SERIAL_PORT_H_

namespace ros {

// Whether Method, the type of a class's availableForWrite, is that of the default in Print, which always returns 0.
template <class Method>
struct IsOfPrint {
  static const bool value = false;
};
template <class Result>
struct IsOfPrint<Result (Print::*)()> {
  static const bool value = true;
};
template <class Result>
struct IsOfPrint<Result (Print::*)() const> {
  static const bool value = true;
};

// A pointer to a port, like `Class*`, that may also point to a port of another class.
template <class Class>
class SerialPort {
 public:
  constexpr SerialPort(Class* port) : stream_(port), control_(nullptr) {}
  template <class Port>
  SerialPort(Port* port) : stream_(port), control_(&control<Port>) {
    sawOtherClass() = true;
  }

  // For members that only `Class` has. Do not use it for a port of another class.
  Class* operator->() const { return &port(); }

  void begin(unsigned long baud) {
    if (isOther()) {
      control_(stream_, baud);
    } else {
      begin(port(), baud, 0);
    }
  }
  int read() { return stream_->read(); }
  void write(const uint8_t* bytes, int count) { write<Class>(bytes, static_cast<size_t>(count), 0); }
  // Returns the number of bytes that write accepts at once. If the port does not report it, this is a large number, and
  // write waits.
  int writable() { return isOther() ? control_(stream_, 0) : room(port(), 0); }

 private:
  static const int ANY_ROOM = 0x7fff;

  // Whether a port of another class exists. If all ports of a program are of `Class`, no code sets this, and the
  // compiler removes the checks.
  static bool& sawOtherClass() {
    static bool saw = false;
    return saw;
  }
  bool isOther() const { return sawOtherClass() && control_; }
  Class& port() const { return static_cast<Class&>(*stream_); }

  // Opens the port at `baud`; returns the free buffer space if `baud` is 0.
  template <class Port>
  static int control(Stream* stream, unsigned long baud) {
    if (!baud) return room(static_cast<Port&>(*stream), 0);
    begin(static_cast<Port&>(*stream), baud, 0);
    return 0;
  }

  template <class Port>
  static auto begin(Port& port, unsigned long baud, int) -> decltype(port.begin(baud), void()) {
    port.begin(baud);
  }
  template <class Port>
  static void begin(Port&, unsigned long, long) {}

  template <class Port, class Method = decltype(&Port::availableForWrite)>
  static int room(Port& port, int) {
    return IsOfPrint<Method>::value ? ANY_ROOM : static_cast<int>(port.availableForWrite());
  }
  template <class Port>
  static int room(Port&, long) {
    return ANY_ROOM;
  }

#if defined(__AVR__)
  // For a port that inherits Print's function to write many bytes, which calls `write` for each byte: calls that
  // directly.
  template <class Port, size_t (Print::*)(const uint8_t*, size_t) = &Port::write>
  void write(const uint8_t* bytes, size_t count, int) {
    for (; count; --count) stream_->write(*bytes++);
  }
#endif
  template <class Port>
  void write(const uint8_t* bytes, size_t count, long) {
    stream_->write(bytes, count);
  }

  Stream* stream_;
  int (*control_)(Stream* stream, unsigned long baud);
};

}  // namespace ros

#endif

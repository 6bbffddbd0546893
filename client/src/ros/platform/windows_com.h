// A serial port of Windows: "COM3", "COM12", "\\.\COM12".
#ifndef ROS_PLATFORM_WINDOWS_COM_H_
#define ROS_PLATFORM_WINDOWS_COM_H_

#include <winsock2.h>
#include <windows.h>

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "ros/platform/pipe_hardware.h"

namespace ros {

// A COM port as a Pipe for PipeHardware: 8N1, without flow control.
class ComPipe {
 public:
  ComPipe() : baud_(57600), handle_(INVALID_HANDLE_VALUE), reason_("") { setName(""); }
  ComPipe(const ComPipe& other) : baud_(other.baud_), handle_(INVALID_HANDLE_VALUE), reason_("") {
    setName(other.name_);
  }
  ComPipe& operator=(const ComPipe&) = delete;

  void setName(const char* name) {
    // From COM10 on, Windows requires the long form.
    snprintf(name_, sizeof name_, "%s%s", *name == '\\' ? "" : "\\\\.\\", name);
  }
  void setBaud(long baud) { baud_ = baud; }
  long baud() const { return baud_; }
  const char* name() const { return name_; }
  const char* reason() const { return reason_; }

  PipeState open(uint32_t) {
    handle_ = CreateFileA(name_, GENERIC_READ | GENERIC_WRITE, 0, nullptr, OPEN_EXISTING, 0, nullptr);
    if (handle_ == INVALID_HANDLE_VALUE) {
      reason_ = GetLastError() == ERROR_ACCESS_DENIED ? "in use by another program" : "no such port";
      return PIPE_FAILED;
    }
    DCB line;
    memset(&line, 0, sizeof line);
    line.DCBlength = sizeof line;
    GetCommState(handle_, &line);
    line.BaudRate = static_cast<DWORD>(baud_);
    line.ByteSize = 8;
    line.Parity = NOPARITY;
    line.StopBits = ONESTOPBIT;
    line.fBinary = TRUE;
    line.fParity = FALSE;
    line.fOutxCtsFlow = line.fOutxDsrFlow = FALSE;
    line.fOutX = line.fInX = FALSE;
    line.fNull = FALSE;
    line.fAbortOnError = FALSE;
    line.fDtrControl = DTR_CONTROL_ENABLE;
    line.fRtsControl = RTS_CONTROL_ENABLE;
    if (!SetCommState(handle_, &line)) {
      reason_ = "does not support this baud rate";
      close();
      return PIPE_FAILED;
    }
    // A read returns the available bytes; a write has a time limit.
    COMMTIMEOUTS limits = {MAXDWORD, 0, 0, 0, WRITE_LIMIT_MS};
    SetCommTimeouts(handle_, &limits);
    SetupComm(handle_, 4096, 4096);
    PurgeComm(handle_, PURGE_RXCLEAR | PURGE_TXCLEAR);
    return PIPE_OPEN;
  }

  int read(uint8_t* bytes, size_t size) {
    DWORD count = 0;
    return ReadFile(handle_, bytes, static_cast<DWORD>(size), &count, nullptr) ? static_cast<int>(count) : -1;
  }
  int write(const uint8_t* bytes, size_t size) {
    DWORD count = 0;
    if (WriteFile(handle_, bytes, static_cast<DWORD>(size), &count, nullptr) || count) return static_cast<int>(count);
    return GetLastError() == ERROR_TIMEOUT ? 0 : -1;
  }
  void wait(uint32_t wait_ms) { Sleep(wait_ms); }
  void close() {
    if (handle_ != INVALID_HANDLE_VALUE) CloseHandle(handle_);
    handle_ = INVALID_HANDLE_VALUE;
  }
  static bool isNetwork() { return false; }
  static uint32_t milliseconds() { return GetTickCount(); }

 private:
  // A write returns after this time even if the port accepts nothing: spinOnce must not block for long.
  static const DWORD WRITE_LIMIT_MS = 50;

  char name_[64];
  long baud_;
  HANDLE handle_;
  const char* reason_;
};

}  // namespace ros

// For programs that only use a serial port: ros::NodeHandle_<WindowsCom>.
class WindowsCom : public ros::PipeHardware<ros::ComPipe> {
 public:
  explicit WindowsCom(const char* name = "COM1", long baud = 57600) : PipeHardware(ros::ComPipe()) {
    pipe().setName(name);
    pipe().setBaud(baud);
  }

  // Takes effect with the next initNode.
  void setBaud(long baud) { pipe().setBaud(baud); }
  long getBaud() { return pipe().baud(); }

  using PipeHardware::init;
  void init(const char* name) {
    pipe().setName(name);
    init();
  }
};

#endif

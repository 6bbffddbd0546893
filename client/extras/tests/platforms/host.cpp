// The platforms' node on an operating system: its port is the first argument, its baud rate the second.
#include "platform_node.h"

#include <stdlib.h>

#if defined(_WIN32)
#include <windows.h>
static void pauseLoop() { Sleep(5); }
#else
#include <unistd.h>
static void pauseLoop() { usleep(5000); }
#endif

int main(int argc, char** argv) {
  if (argc > 2) nh.getHardware()->setBaud(atol(argv[2]));
  if (argc > 1) {
    nh.initNode(argv[1]);
  } else {
    nh.initNode();
  }
  setupNode();
  for (;;) {
    loopNode();
    pauseLoop();
  }
}

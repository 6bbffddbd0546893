// Runs an Arduino sketch on a platform without Arduino: -DSKETCH='"path/X.ino"'. It provides the time, pins that keep
// their level, and the rest of Arduino that simple sketches use.
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define HIGH 1
#define LOW 0
#define INPUT 0
#define OUTPUT 1
#define PI 3.1415926535897932384626433832795
#define TWO_PI (2 * PI)

static uint8_t levels[32];
inline void pinMode(int, int) {}
inline void digitalWrite(int pin, int level) { levels[pin] = static_cast<uint8_t>(level); }
inline int digitalRead(int pin) { return levels[pin]; }

unsigned long millis();
void delay(unsigned long wait_ms);

#include SKETCH

unsigned long millis() { return nh.time(); }

#if defined(__unix__)
#include <unistd.h>
static void pauseShortly() { usleep(1000); }
#else
static void pauseShortly() { __asm__ volatile("wfi"); }
#endif

void delay(unsigned long wait_ms) {
  const unsigned long began_ms = millis();
  while (millis() - began_ms < wait_ms) pauseShortly();
}

int main() {
  setup();
  for (;;) loop();
}

// The lines and pins of the board. The lines are file descriptors that the simulation passes, with their numbers in
// environment variables: OPENCR_USB is a terminal, OPENCR_DXL and OPENCR_BLUETOOTH transfer bytes, and OPENCR_PINS
// transfers lines of text:
//
//   pin 34 1                    a level: from the simulation for an input, to the simulation for an output
//   adc 17 512                  a voltage, 0 to 1023
//   sonar 583                   the time of an echo in microseconds; 0: no echo
//   motion RATE[3] ACCELERATION[3] FIELD[3]   the values of the IMU: rad/s, m/s^2, tesla
//   tone 440 250                to the simulation: a tone in hertz and milliseconds (0: until the next tone)
//
// The program ends when the simulation closes the pins.
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

#include "Arduino.h"
#include "SPI.h"
#include "mpu9250_chip.h"

static int levels[PINS_COUNT];
static int voltages[PINS_COUNT];
static unsigned long echo_us;
static Mpu9250Chip imu_chip;

USBSerial Serial("OPENCR_USB");
UARTClass Serial3("OPENCR_DXL");
UARTClass Serial4("OPENCR_BLUETOOTH");
SPIClass SPI_IMU;
static Line pins("OPENCR_PINS");

static int descriptorOf(const char* variable) {
  const char* text = getenv(variable);
  if (!text) {
    fprintf(stderr, "%s is not set; start this program with `rostether board run --board opencr`\n", variable);
    exit(2);
  }
  const int fd = atoi(text);
  fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
  return fd;
}

Line::Line(const char* variable) : fd_(descriptorOf(variable)), received_bytes_(0), read_bytes_(0) {}

int Line::available() {
  if (read_bytes_ == received_bytes_) {
    const ssize_t count = ::read(fd_, received_, sizeof received_);
    // A terminal without a program at its other end reports an error.
    if (count == 0 && this == &pins) exit(0);
    read_bytes_ = 0;
    received_bytes_ = count > 0 ? static_cast<size_t>(count) : 0;
  }
  return static_cast<int>(received_bytes_ - read_bytes_);
}

int Line::read() { return available() > 0 ? received_[read_bytes_++] : -1; }

// Waits up to 0.1 s for a slow reader, then drops the rest, as USB does.
size_t Line::write(const uint8_t* bytes, size_t size) {
  size_t written = 0;
  while (written < size) {
    struct pollfd waited = {fd_, POLLOUT, 0};
    // A terminal without a program would keep the bytes for the next one.
    if (poll(&waited, 1, 100) <= 0 || waited.revents & (POLLHUP | POLLERR)) break;
    const ssize_t count = ::write(fd_, bytes + written, size - written);
    if (count > 0) written += static_cast<size_t>(count);
    else if (errno != EAGAIN && errno != EINTR) break;
  }
  return written;
}

static void obey(const char* line) {
  int pin, value;
  unsigned long us;
  double v[9];
  if (sscanf(line, "pin %d %d", &pin, &value) == 2) {
    if (pin >= 0 && pin < PINS_COUNT) levels[pin] = value;
  } else if (sscanf(line, "adc %d %d", &pin, &value) == 2) {
    if (pin >= 0 && pin < PINS_COUNT) voltages[pin] = value;
  } else if (sscanf(line, "sonar %lu", &us) == 1) {
    echo_us = us;
  } else if (sscanf(line, "motion %lf %lf %lf %lf %lf %lf %lf %lf %lf", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6,
                    v + 7, v + 8) == 9) {
    imu_chip.setValues({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]});
  } else {
    fprintf(stderr, "not a line of the simulation: %s\n", line);
  }
}

static void readPins() {
  static char line[256];
  static size_t size = 0;
  for (int byte; (byte = pins.read()) >= 0;) {
    if (byte != '\n') {
      if (size < sizeof line - 1) line[size++] = static_cast<char>(byte);
      continue;
    }
    line[size] = '\0';
    size = 0;
    obey(line);
  }
}

static void report(const char* text, int size) {
  pins.write(reinterpret_cast<const uint8_t*>(text), static_cast<size_t>(size));
}

void pinMode(int, int) {}
void digitalWrite(int pin, int level) {
  if (pin < 0 || pin >= PINS_COUNT) return;
  if (pin == BDPIN_SPI_CS_IMU && level == LOW) imu_chip.select();
  const bool has_changed = levels[pin] != level;
  levels[pin] = level;
  // Pins that change with each measurement would flood the simulation.
  if (!has_changed || pin == BDPIN_SPI_CS_IMU || pin == BDPIN_GPIO_1 || pin == 44) return;
  char text[32];
  report(text, snprintf(text, sizeof text, "pin %d %d\n", pin, level));
}
int digitalRead(int pin) { return pin >= 0 && pin < PINS_COUNT ? levels[pin] : LOW; }
int analogRead(int pin) { return pin >= 0 && pin < PINS_COUNT ? voltages[pin < 6 ? A0 + pin : pin] : 0; }

void tone(int, unsigned int hertz, unsigned long length_ms) {
  char text[64];
  report(text, snprintf(text, sizeof text, "tone %u %lu\n", hertz, length_ms));
}
void noTone(int pin) { tone(pin, 0, 0); }

unsigned long pulseIn(int, int, unsigned long timeout_us) {
  const bool comes = echo_us > 0 && echo_us < timeout_us;
  delayMicroseconds(comes ? echo_us : timeout_us);
  return comes ? echo_us : 0;
}

static uint64_t nanoseconds() {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<uint64_t>(now.tv_sec) * 1000000000u + static_cast<uint64_t>(now.tv_nsec);
}
static const uint64_t started_ns = nanoseconds();
// The clocks have 32 bits, as on the board.
unsigned long millis() { return static_cast<uint32_t>((nanoseconds() - started_ns) / 1000000); }
unsigned long micros() { return static_cast<uint32_t>((nanoseconds() - started_ns) / 1000); }
void delay(unsigned long wait_ms) { usleep(static_cast<useconds_t>(wait_ms * 1000)); }
void delayMicroseconds(unsigned long wait_us) { usleep(static_cast<useconds_t>(wait_us)); }

// As on the board: a divider of 5.7 before a converter for 3.3 V.
float getPowerInVoltage() { return static_cast<float>(analogRead(BDPIN_BAT_PWR_ADC)) * (3.3f * 5.7f / 1023); }
uint8_t getPushButton() {
  return static_cast<uint8_t>(digitalRead(BDPIN_PUSH_SW_1) | digitalRead(BDPIN_PUSH_SW_2) << 1);
}
void drv_dxl_tx_enable(int) {}

uint8_t SPIClass::transfer(uint8_t sent) { return imu_chip.transfer(sent); }

int main() {
  // The levels of the LEDs when they are off.
  for (int pin = BDPIN_LED_USER_1; pin <= BDPIN_LED_USER_4; ++pin) levels[pin] = HIGH;
  readPins();
  setup();
  for (;;) {
    loop();
    readPins();
    // Otherwise the loop would use a whole processor.
    struct pollfd waited[] = {{Serial.descriptor(), POLLIN, 0}, {pins.descriptor(), POLLIN, 0}};
    if (Serial.available() > 0) continue;
    poll(waited, 2, 1);
    // A terminal without a program at its other end ends each wait immediately.
    if (waited[0].revents & POLLHUP) delay(1);
  }
}

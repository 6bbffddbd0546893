/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The simulated board: one process, one board. It links libsimavr (GPL-3), so it is a separate program;
 * rostether starts it, and they exchange lines: commands on stdin, JSON events on stdout.
 *
 *     main -> pacing -> core (instructions)      commands <- stdin
 *                        |                        events  -> stdout
 *     uart <-> faults <-> link (pty, TCP)        pins, pulses, wheels, adc, sonar, network, canaries
 *                                                twi -> mpu9150, spi -> w5100 -> w5100_network
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <sim_avr.h>

#define CLOCK_HZ 16000000u
#define CYCLES_PER_US (CLOCK_HZ / 1000000u)
#define CYCLES_PER_MS (CLOCK_HZ / 1000u)
#define NEVER UINT64_MAX

typedef avr_cycle_count_t cycles_t;

/* A digital pin by its Arduino name; channel is the ADC input, -1 for none. */
struct pin_place {
    const char *name;
    char port;
    int8_t bit;
    int8_t channel;
};

struct board_kind {
    const char *name;
    const char *mcu;
    char link_uart; /* the UART behind the USB port; on a Leonardo that of the pins D0 and D1 */
    const struct pin_place *pins;
    size_t pin_count;
};

const struct board_kind *board_kind_named(const char *name);
const struct pin_place *pin_place_named(const struct board_kind *kind, const char *name);

struct board {
    avr_t *avr;
    const struct board_kind *kind;
    bool fast;          /* as fast as possible instead of in real time */
    bool powered;
    bool running;       /* false while paused, and after the end of `run` */
    bool quitting;
    bool quits_at_stop; /* the command `for`: the program ends when the run ends */
    cycles_t stop_at;
    uint32_t heap_end_place; /* the address of malloc's variable with the heap's end; 0 without malloc */
};
extern struct board board;

/* core.c: runs instructions up to a cycle, with checks between them. */
void core_run_until(cycles_t target);
void core_reset(void);

/* power.c: resets and power. */
void power_on(const char *cause);
void power_off(void);
void power_reset(const char *cause);
void power_seed(uint64_t seed);

/* pacing.c: real time, slices, and the work between them. */
int pacing_loop(void);
void pacing_rebase(void);

/* firmware.c: ELF and HEX files, symbols. */
struct symbol {
    char *name;
    uint32_t address; /* in data space */
    uint32_t size;
};
bool firmware_load(const char *path, char *error, size_t room);
const struct symbol *firmware_symbol(const char *name);
uint32_t firmware_heap_start(void);
uint32_t firmware_heap_end(void);

/* uart.c: one USART, accurate to the bit time. */
bool uart_start(char name);
void uart_reset(void);
size_t uart_room(void);
void uart_receive(uint8_t byte, bool delayed);
void uart_report_overruns(void);

/* faults.c: damages bytes like a bad line. */
enum direction { TO_BOARD, FROM_BOARD };
struct faulty_byte {
    uint8_t byte;
    bool lost;
    bool delayed;
};
struct faulty_byte faults_apply(enum direction direction, uint8_t byte);
cycles_t faults_delay_cycles(enum direction direction);
const char *faults_set(char *settings);

/* link.c: the host's end of the UART. */
bool link_open_pty(void);
bool link_open_tcp(unsigned port);
const char *link_address(void);
void link_receive(void);
void link_send(uint8_t byte);
void link_flush(void);
void link_watch(bool on);
void link_power(bool on);
void link_autoreset(bool on);
const char *link_inject(const char *hex);
void link_close(void);

/* pins.c: levels, by Arduino name. */
struct pin;
typedef void (*pin_listener)(struct pin *pin, bool level);
struct pin *pin_named(const char *name);
const char *pin_name(const struct pin *pin);
const struct pin_place *pin_place(const struct pin *pin);
bool pin_level(const struct pin *pin);
bool pin_is_output(const struct pin *pin);
void pin_listen(struct pin *pin, pin_listener listener);
void pin_ignore(struct pin *pin, pin_listener listener);
void pin_drive(struct pin *pin, bool level);
void pin_release(struct pin *pin);
bool pin_watch(struct pin *pin, bool on);
void pins_reset(void);

/* timers.c: the effect of timers on pins. */
struct pwm {
    bool active;
    double duty;
    double period_us;
};
void timers_start(void);
bool timers_drive(const struct pin_place *place);
struct pwm timers_pwm(const struct pin_place *place);

/* pulses.c: reports of PWM, and of servo pulses on any pin. */
const char *pulses_watch_pwm(struct pin *pin, bool on);
const char *pulses_watch_servo(struct pin *pin, bool on);
bool pulses_report_servo(const struct pin *pin);
void pulses_update(void);

/* wheels.c: two motors, and the robot's pose. */
void wheels_start(void);
void wheels_move(void);
void wheels_report(void);
const char *wheels_set(char *settings);

/* adc.c: voltages on analog inputs. */
void adc_start(void);
void adc_set(int channel, double volts);
void adc_set_reference(double volts);

/* sonar.c: an HC-SR04. */
void sonar_wire(struct pin *trig, struct pin *echo);
bool sonar_is_wired(void);
void sonar_set_range(double meters); /* negative: no obstacle */
void sonar_reset(void);

/* twi.c, mpu9150.c, magnetometer.c, attitude.c: sensors on I2C. */
struct twi_device {
    uint8_t address;
    bool (*answers)(void);
    void (*begin)(void);
    void (*write)(uint8_t byte);
    uint8_t (*read)(void);
};
void twi_start(void);
extern const struct twi_device mpu9150_device, magnetometer_device;
bool mpu9150_bypass(void);
void mpu9150_power_up(void);
void magnetometer_power_up(void);

struct vector {
    double x, y, z;
};
void attitude_set(double roll, double pitch, double yaw, double duration_s);
void attitude_measure(struct vector *gravity_g, struct vector *turn_rate_dps, struct vector *field_ut);

/* network.c: the simulated network chip on GPIOR0 and GPIOR1. */
const char *network_connects_to(const char *host_and_port);
void network_start(void);
void network_move(void);
void network_reset(void);

/* spi.c, w5100.c, w5100_network.c: an Ethernet shield. */
void spi_start(void);
void w5100_start(void);
void w5100_reset(void);
bool w5100_is_selected(void);
uint8_t w5100_exchange(uint8_t byte);
void w5100_move(void);
void w5100_set_stall(unsigned long after);
const char *w5100_set(char *settings);

/* markers.c: counts the cycles between GPIOR2 = 1 and GPIOR2 = 0. */
void markers_start(void);

/* canaries.c: stack, bad accesses, guarded memory. */
void canaries_start(void);
void canaries_fill(void);
void canaries_check_stack(void);
void canaries_heap_moved(void);
void canaries_check_store(void);
void canaries_check_interrupt(void);
extern bool canaries_guarding;
const char *canaries_guard(const char *place);
int canaries_free_stack(void);
bool canaries_place(const char *text, uint32_t *from, uint32_t *end);
void canaries_report_restart(uint32_t from);

/* commands.c: performs commands; returns NULL, or the error. */
const char *command_perform(char *line);

/* lines.c: commands from stdin and from the command line. */
void command_run(char *line);
void commands_read(void);

/* events.c: one JSON line for each event. */
void events_open(int fd);
void event_begin(const char *name);
void event_text(const char *key, const char *value);
void event_int(const char *key, long long value);
void event_number(const char *key, double value, int decimals);
void event_bool(const char *key, bool value);
void event_hex(const char *key, const uint8_t *bytes, size_t count);
void event_end(void);
void event_end_droppable(void);
void events_flush(void);

#endif

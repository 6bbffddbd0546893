/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The commands for the board, before its first instruction and while it runs.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"

#define MAX_WORDS 8
#define HIGHEST_VOLTS 5.5
#define LONGEST_READ 4096

typedef const char *(*word_action)(int count, char **words);

static bool read_number(const char *text, double *value) {
    char *rest;
    *value = strtod(text, &rest);
    return rest != text && !*rest && isfinite(*value);
}

static char *split(char *text) {
    char *value = strchr(text, '=');
    if (value) *value++ = 0;
    return value;
}

static const char *digital_pin(const char *name, struct pin **pin) {
    *pin = pin_named(name);
    if (!*pin) return "this board has no such pin; write pins as D13 or A0";
    return pin_place(*pin)->bit < 0 ? "this pin is only an analog input; set it with adc" : NULL;
}

static const char *do_adc(int count, char **words) {
    for (int i = 1; i < count; i++) {
        double volts;
        char *value = split(words[i]);
        const struct pin_place *place = pin_place_named(board.kind, words[i]);
        if (!place || place->channel < 0) return "this board has no such analog input; write it as A0";
        if (!value || !read_number(value, &volts) || volts < 0 || volts > HIGHEST_VOLTS)
            return "write volts from 0 to 5.5, as in adc A0=2.5";
        adc_set(place->channel, volts);
    }
    return NULL;
}

static const char *do_aref(int count, char **words) {
    double volts;
    if (count != 2 || !read_number(words[1], &volts) || volts < 0.5 || volts > HIGHEST_VOLTS)
        return "write volts from 0.5 to 5.5, as in aref 3.3";
    adc_set_reference(volts);
    return NULL;
}

static void report_pin(struct pin *pin) {
    event_begin("pin");
    event_text("pin", pin_name(pin));
    event_int("level", pin_level(pin));
    event_bool("output", pin_is_output(pin));
    event_end();
}

static const char *do_pin(int count, char **words) {
    for (int i = 1; i < count; i++) {
        char *value = split(words[i]);
        struct pin *pin;
        const char *error = digital_pin(words[i], &pin);
        if (error) return error;
        if (!value)
            report_pin(pin);
        else if (strcmp(value, "0") == 0 || strcmp(value, "1") == 0)
            pin_drive(pin, *value == '1');
        else if (strcmp(value, "z") == 0)
            pin_release(pin);
        else
            return "drive a pin with pin D7=0 or D7=1, and release it with pin D7=z";
    }
    return NULL;
}

/* Reports all digital pins: "in1", "out0", or "pwm0.503" if a timer drives the pin. */
static const char *do_pins(int count, char **words) {
    (void)count, (void)words;
    event_begin("pins");
    for (size_t i = 0; i < board.kind->pin_count; i++) {
        struct pin *pin = pin_named(board.kind->pins[i].name);
        if (board.kind->pins[i].bit < 0) continue;
        char text[24];
        struct pwm pwm = timers_pwm(pin_place(pin));
        bool output = pin_is_output(pin);
        if (output && pwm.active)
            snprintf(text, sizeof text, "pwm%.3f", pwm.duty);
        else
            snprintf(text, sizeof text, "%s%d", output ? "out" : "in", pin_level(pin));
        event_text(pin_name(pin), text);
    }
    event_end_droppable();
    return NULL;
}

static const char *watch(const char *name, bool on) {
    struct pin *pin;
    if (strcmp(name, "serial") == 0) return link_watch(on), NULL;
    const char *error = digital_pin(name, &pin);
    if (!error) error = pulses_watch_pwm(pin, on);
    if (!error && pin_watch(pin, on) && on) report_pin(pin);
    return error;
}

static const char *do_watch(int count, char **words) {
    const char *error = NULL;
    for (int i = 1; i < count && !error; i++) error = watch(words[i], true);
    return error;
}

static const char *do_unwatch(int count, char **words) {
    const char *error = NULL;
    struct pin *pin;
    for (int i = 1; i < count && !error; i++) {
        error = watch(words[i], false);
        if (!error && (pin = pin_named(words[i]))) pulses_watch_servo(pin, false);
    }
    return error;
}

static const char *do_servo(int count, char **words) {
    for (int i = 1; i < count; i++) {
        struct pin *pin;
        const char *error = digital_pin(words[i], &pin);
        if (!error && !pulses_report_servo(pin)) error = pulses_watch_servo(pin, true);
        if (error) return error;
    }
    return NULL;
}

static const char *do_hcsr04(int count, char **words) {
    struct pin *trig = NULL, *echo = NULL;
    char *rest = NULL;
    for (char *part = count == 2 ? strtok_r(words[1], ",", &rest) : NULL; part; part = strtok_r(NULL, ",", &rest)) {
        char *value = split(part);
        struct pin **wanted = strcmp(part, "trig") == 0 ? &trig : strcmp(part, "echo") == 0 ? &echo : NULL;
        const char *error = wanted && value ? digital_pin(value, wanted) : "write the pins as in hcsr04 trig=D6,echo=D5";
        if (error) return error;
    }
    if (!trig || !echo || trig == echo) return "write the pins as in hcsr04 trig=D6,echo=D5";
    sonar_wire(trig, echo);
    return NULL;
}

static const char *do_range(int count, char **words) {
    double meters = -1;
    bool none = count == 2 && strcmp(words[1], "none") == 0;
    if (count != 2 || (!none && (!read_number(words[1], &meters) || meters < 0)))
        return "write the distance in meters, as in range 0.5, or range none";
    /* The pins of the established Ultrasound sketch. */
    if (!sonar_is_wired()) sonar_wire(pin_named("D6"), pin_named("D5"));
    sonar_set_range(meters);
    return NULL;
}

static const char *do_attitude(int count, char **words) {
    double angles[3] = {0}, seconds = 0;
    bool fits = count == 4 || (count == 6 && strcmp(words[4], "in") == 0 && read_number(words[5], &seconds));
    for (int i = 0; fits && i < 3; i++) fits = read_number(words[i + 1], &angles[i]);
    if (!fits || seconds < 0) return "write the angles in degrees: attitude ROLL PITCH YAW [in SECONDS]";
    attitude_set(angles[0], angles[1], angles[2], seconds);
    return NULL;
}

static const char *do_fault(int count, char **words) {
    return count == 2 ? faults_set(words[1]) : "write faults as in fault flip=0.01,drop=0.001,seed=3";
}

static const char *do_reset(int count, char **words) {
    (void)count, (void)words;
    power_reset("external");
    return NULL;
}

static const char *do_power(int count, char **words) {
    bool on = count == 2 && strcmp(words[1], "on") == 0;
    if (count != 2 || (!on && strcmp(words[1], "off") != 0)) return "write power on, or power off";
    if (!on)
        power_off();
    else if (!board.powered)
        power_on("power");
    return NULL;
}

static const char *do_autoreset(int count, char **words) {
    bool on = count == 2 && strcmp(words[1], "on") == 0;
    if (count != 2 || (!on && strcmp(words[1], "off") != 0)) return "write autoreset on, or autoreset off";
    link_autoreset(on);
    return NULL;
}

static bool read_cycles(const char *text, cycles_t *cycles) {
    static const struct {
        const char *unit;
        double cycles;
    } units[] = {{"", 1}, {"us", CYCLES_PER_US}, {"ms", CYCLES_PER_MS}, {"s", CLOCK_HZ}};
    char *unit;
    double value = strtod(text, &unit);
    for (size_t i = 0; unit != text && value >= 0 && value < 1e15 && i < sizeof units / sizeof *units; i++)
        if (strcmp(unit, units[i].unit) == 0) return *cycles = (cycles_t)(value * units[i].cycles), true;
    return false;
}

static const char *do_run(int count, char **words) {
    cycles_t cycles = 0;
    if (count > 2 || (count == 2 && !read_cycles(words[1], &cycles)))
        return "write how long to run in cycles or with a unit, as in run 160000 or run 20ms";
    board.stop_at = count == 2 ? board.avr->cycle + cycles : NEVER;
    board.running = true;
    pacing_rebase();
    return NULL;
}

static const char *do_for(int count, char **words) {
    board.quits_at_stop = true;
    return do_run(count, words);
}

static const char *do_pause(int count, char **words) {
    (void)count, (void)words;
    board.running = false;
    return NULL;
}

static const char *do_cycles(int count, char **words) {
    (void)count, (void)words;
    event_begin("cycles");
    event_int("cycles", (long long)board.avr->cycle);
    event_end();
    return NULL;
}

static const char *do_memory(int count, char **words) {
    uint32_t from, end;
    double bytes = 0;
    if (count < 2 || count > 3 || !canaries_place(words[1], &from, &end) || (count == 3 && !read_number(words[2], &bytes)))
        return "write memory SYMBOL, or memory 0x100 16 for 16 bytes";
    if (count == 3) end = from + (uint32_t)fmin(fmax(bytes, 1), LONGEST_READ);
    if (end > board.avr->ramend + 1u) end = board.avr->ramend + 1u;
    if (end - from > LONGEST_READ) end = from + LONGEST_READ;
    event_begin("memory");
    event_text("place", words[1]);
    event_int("address", from);
    event_hex("data", board.avr->data + from, end - from);
    event_end();
    return NULL;
}

static const char *do_stack(int count, char **words) {
    (void)count, (void)words;
    int free_bytes = canaries_free_stack();
    if (free_bytes < 0) return "the program has no symbols; load its ELF file instead";
    event_begin("stack");
    event_int("free_bytes", free_bytes);
    event_end();
    return NULL;
}

static const char *do_guard(int count, char **words) {
    return canaries_guard(count == 2 ? words[1] : "");
}

static const char *do_send(int count, char **words) { return link_inject(count == 2 ? words[1] : "?"); }

static const char *do_network(int count, char **words) { return network_connects_to(count == 2 ? words[1] : ""); }

static const char *do_w5100(int count, char **words) {
    return count == 2 ? w5100_set(words[1]) : "write the settings as in w5100 address=127.0.0.2,stall_after=500";
}

static const char *do_wheels(int count, char **words) {
    if (count > 1) return wheels_set(words[1]);
    wheels_report();
    return NULL;
}

static const char *do_quit(int count, char **words) {
    (void)count, (void)words;
    board.quitting = true;
    return NULL;
}

static const struct {
    const char *word;
    word_action action;
} vocabulary[] = {
    {"adc", do_adc},         {"aref", do_aref},   {"attitude", do_attitude}, {"autoreset", do_autoreset},
    {"cycles", do_cycles},   {"fault", do_fault}, {"for", do_for},           {"guard", do_guard},
    {"hcsr04", do_hcsr04},   {"memory", do_memory}, {"network", do_network}, {"pause", do_pause},
    {"pin", do_pin},         {"pins", do_pins},   {"power", do_power},       {"quit", do_quit},
    {"range", do_range},     {"reset", do_reset}, {"run", do_run},           {"send", do_send},
    {"servo", do_servo},     {"stack", do_stack}, {"unwatch", do_unwatch},   {"w5100", do_w5100},
    {"watch", do_watch},   {"wheels", do_wheels},
};

const char *command_perform(char *line) {
    char *words[MAX_WORDS], *rest = NULL;
    int count = 0;
    for (char *word = strtok_r(line, " \t\r\n", &rest); word; word = strtok_r(NULL, " \t\r\n", &rest)) {
        if (count == MAX_WORDS) return "too many words in one line";
        words[count++] = word;
    }
    if (count == 0 || *words[0] == '#') return NULL;
    for (size_t i = 0; i < sizeof vocabulary / sizeof *vocabulary; i++)
        if (strcmp(vocabulary[i].word, words[0]) == 0) return vocabulary[i].action(count, words);
    return "no such command; the commands are adc aref attitude autoreset cycles fault guard hcsr04 memory network pause pin pins power "
           "quit range reset run send servo stack unwatch w5100 watch wheels";
}

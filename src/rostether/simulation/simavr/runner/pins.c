/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Digital pins: listeners for their levels, and levels from outside. While an input is driven from outside, it reads
 * that level; otherwise it reads its pull-up, or low.
 */
#include <avr_extint.h>
#include <avr_ioport.h>

#include "board.h"

#define LISTENERS 4
#define MAX_PINS 80

struct pin {
    const struct pin_place *place;
    avr_irq_t *irq;
    bool hooked, level, watched;
    pin_listener listeners[LISTENERS];
};

static struct pin pins[MAX_PINS];
static struct {
    uint8_t mask, value;
} driven['L' + 1];

const char *pin_name(const struct pin *pin) { return pin->place->name; }

const struct pin_place *pin_place(const struct pin *pin) { return pin->place; }

struct pin *pin_named(const char *name) {
    const struct pin_place *place = pin_place_named(board.kind, name);
    if (!place) return NULL;
    struct pin *pin = &pins[place - board.kind->pins];
    if (!pin->place) {
        pin->place = place;
        if (place->bit >= 0)
            pin->irq = avr_io_getirq(board.avr, AVR_IOCTL_IOPORT_GETIRQ(place->port), place->bit);
    }
    return pin;
}

static avr_ioport_state_t port_state(const struct pin *pin) {
    avr_ioport_state_t state = {0};
    avr_ioctl(board.avr, AVR_IOCTL_IOPORT_GETSTATE(pin->place->port), &state);
    return state;
}

bool pin_is_output(const struct pin *pin) { return port_state(pin).ddr >> pin->place->bit & 1; }

bool pin_level(const struct pin *pin) {
    avr_ioport_state_t state = port_state(pin);
    return (state.ddr >> pin->place->bit & 1 ? state.port : state.pin) >> pin->place->bit & 1;
}

static void on_change(struct avr_irq_t *irq, uint32_t value, void *param) {
    struct pin *pin = param;
    bool level = value & 0xff;
    (void)irq;
    if (level == pin->level) return;
    pin->level = level;
    for (int i = 0; i < LISTENERS; i++)
        if (pin->listeners[i]) pin->listeners[i](pin, level);
}

void pin_listen(struct pin *pin, pin_listener listener) {
    pin_ignore(pin, listener);
    if (!pin->hooked) {
        pin->hooked = true;
        pin->level = pin_level(pin);
        avr_irq_register_notify(pin->irq, on_change, pin);
    }
    for (int i = 0; i < LISTENERS; i++)
        if (!pin->listeners[i]) {
            pin->listeners[i] = listener;
            return;
        }
}

void pin_ignore(struct pin *pin, pin_listener listener) {
    for (int i = 0; i < LISTENERS; i++)
        if (pin->listeners[i] == listener) pin->listeners[i] = NULL;
}

static void apply_external(char port) {
    avr_ioport_external_t external = {
        .name = (unsigned)port & 0x7f,
        .mask = driven[(int)port].mask,
        .value = driven[(int)port].value,
    };
    avr_ioctl(board.avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(port), &external);
}

void pin_drive(struct pin *pin, bool level) {
    int port = pin->place->port;
    uint8_t mask = (uint8_t)(1 << pin->place->bit);
    driven[port].mask |= mask;
    driven[port].value = (uint8_t)((driven[port].value & ~mask) | (level ? mask : 0));
    apply_external((char)port);
    if (board.powered && !pin_is_output(pin)) avr_raise_irq(pin->irq, level);
}

void pin_release(struct pin *pin) {
    int port = pin->place->port;
    uint8_t mask = (uint8_t)(1 << pin->place->bit);
    driven[port].mask &= (uint8_t)~mask;
    driven[port].value &= (uint8_t)~mask;
    apply_external((char)port);
    if (board.powered && !pin_is_output(pin)) avr_raise_irq(pin->irq, port_state(pin).port >> pin->place->bit & 1);
}

static void report_level(struct pin *pin, bool level) {
    /* A timer that drives the pin is reported as PWM. */
    if (timers_pwm(pin->place).active) return;
    event_begin("pin");
    event_text("pin", pin->place->name);
    event_int("level", level);
    event_end_droppable();
}

/* Starts or stops reporting a pin's changes; returns whether that is a change. */
bool pin_watch(struct pin *pin, bool on) {
    if (pin->watched == on) return false;
    pin->watched = on;
    if (on)
        pin_listen(pin, report_level);
    else
        pin_ignore(pin, report_level);
    return true;
}

/*
 * By default, the simulator checks the pin of each external interrupt in every cycle while the pin is low, to repeat an
 * interrupt "at low level". Hardly any program uses it, so it occurs only once here. Each reset undoes this setting.
 */
static void trigger_low_levels_once(void) {
    for (uint8_t number = 0; number < EXTINT_COUNT; number++) avr_extint_set_strict_lvl_trig(board.avr, number, 0);
}

/* After a reset, all pins are inputs without pull-up. */
void pins_reset(void) {
    trigger_low_levels_once();
    for (size_t i = 0; i < board.kind->pin_count; i++) {
        const struct pin_place *place = &board.kind->pins[i];
        if (place->bit < 0) continue;
        struct pin *pin = pin_named(place->name);
        uint8_t mask = (uint8_t)(1 << place->bit);
        bool level = board.powered && driven[(int)place->port].value & mask;
        avr_raise_irq(pin->irq, level);
    }
}

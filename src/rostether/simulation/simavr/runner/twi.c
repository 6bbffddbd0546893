/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The I2C bus: connects the AVR, the master, with the device that it addresses. */
#include <avr_twi.h>

#include "board.h"

static const struct twi_device *const devices[] = {&mpu9150_device, &magnetometer_device};
static const struct twi_device *selected;
static avr_irq_t *to_avr;

static const struct twi_device *device_at(uint8_t address) {
    for (size_t i = 0; i < sizeof devices / sizeof *devices; i++)
        if (devices[i]->address == address && devices[i]->answers()) return devices[i];
    return NULL;
}

static void on_bus(struct avr_irq_t *irq, uint32_t value, void *param) {
    avr_twi_msg_irq_t message = {.u.v = value};
    uint8_t kind = message.u.twi.msg, address = message.u.twi.addr;
    (void)irq, (void)param;
    if (kind & TWI_COND_STOP) selected = NULL;
    if (kind & TWI_COND_START) {
        selected = device_at(address >> 1);
        if (!selected) return;
        if (!(address & 1)) selected->begin();
        avr_raise_irq(to_avr, avr_twi_irq_msg(TWI_COND_ACK, address, 1));
        return;
    }
    if (!selected) return;
    if (kind & TWI_COND_WRITE) {
        selected->write(message.u.twi.data);
        avr_raise_irq(to_avr, avr_twi_irq_msg(TWI_COND_ACK, address, 1));
    }
    if (kind & TWI_COND_READ)
        avr_raise_irq(to_avr, avr_twi_irq_msg(TWI_COND_READ, address, selected->read()));
}

void twi_start(void) {
    avr_irq_t *from_avr = avr_io_getirq(board.avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_OUTPUT);
    to_avr = avr_io_getirq(board.avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_INPUT);
    if (from_avr) avr_irq_register_notify(from_avr, on_bus, NULL);
}

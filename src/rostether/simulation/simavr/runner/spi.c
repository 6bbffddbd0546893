/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The SPI master: exchanges a byte with the selected chip, in as many cycles as the sketch's SPI clock needs. The
 * simulator's own SPI would need 100 µs for each byte.
 */
#include <string.h>

#include <avr_spi.h>

#include "board.h"

#define BITS 8

static avr_spi_t *spi;

static cycles_t on_exchanged(avr_t *avr, cycles_t when, void *param) {
    (void)when, (void)param;
    avr_raise_interrupt(avr, &spi->spi);
    return 0;
}

static unsigned cycles_per_bit(avr_t *avr) {
    unsigned divisor = 4u << 2 * (avr_regbit_get(avr, spi->spr[0]) | avr_regbit_get(avr, spi->spr[1]) << 1);
    if (divisor > 128) divisor = 128;
    return avr_regbit_get(avr, spi->spr[2]) && divisor < 128 ? divisor / 2 : divisor;
}

static void write_data(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    (void)param;
    avr->data[address] = value;
    if (!avr_regbit_get(avr, spi->spe) || !avr_regbit_get(avr, spi->mstr)) return;
    avr_regbit_clear(avr, spi->spi.raised);
    spi->input_data_register = w5100_is_selected() ? w5100_exchange(value) : 0xff;
    avr_cycle_timer_register(avr, cycles_per_bit(avr) * BITS, on_exchanged, NULL);
}

void spi_start(void) {
    for (avr_io_t *port = board.avr->io_port; port; port = port->next)
        if (strcmp(port->kind, "spi") == 0) spi = (avr_spi_t *)port;
    if (spi) board.avr->io[AVR_DATA_TO_IO(spi->r_spdr)].w.c = write_data;
}

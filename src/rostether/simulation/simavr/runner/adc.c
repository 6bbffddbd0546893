/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Voltages on analog inputs. The simulator times the conversion. The result is computed here, V * 1024 / Vref as in the
 * data sheet, for all channels (the simulator knows eight).
 */
#include <string.h>

#include <avr_adc.h>

#include "board.h"

#define CHANNELS 16
#define SUPPLY_VOLTS 5.0
#define FULL_SCALE 1023
#define TEMPERATURE_VOLTS 0.314 /* at 25 °C, from the data sheet */

static double volts[CHANNELS];
static double reference_pin_volts = SUPPLY_VOLTS;
static avr_adc_t *adc;
static unsigned result;

void adc_set(int channel, double value) {
    if (channel >= 0 && channel < CHANNELS) volts[channel] = value;
}

void adc_set_reference(double value) { reference_pin_volts = value; }

static double reference_volts(void) {
    uint16_t reference = adc->ref_values[avr_regbit_get_array(board.avr, adc->ref, ARRAY_SIZE(adc->ref))];
    if (reference == ADC_VREF_AREF) return reference_pin_volts;
    return reference == ADC_VREF_VCC || reference == ADC_VREF_AVCC ? SUPPLY_VOLTS : reference / 1000.0;
}

static double measured_volts(void) {
    avr_adc_mux_t input = adc->muxmode[avr_regbit_get_array(board.avr, adc->mux, ARRAY_SIZE(adc->mux))];
    switch (input.kind) {
    case ADC_MUX_SINGLE:
        return volts[input.src % CHANNELS];
    case ADC_MUX_DIFF:
        return (volts[input.src % CHANNELS] - volts[input.diff % CHANNELS]) * (input.gain ? input.gain : 1);
    case ADC_MUX_TEMP:
        return TEMPERATURE_VOLTS;
    case ADC_MUX_REF:
        return input.src / 1000.0;
    case ADC_MUX_VCC4:
        return SUPPLY_VOLTS / 4;
    default:
        return 0;
    }
}

/* The input is sampled when the conversion starts. */
static void on_start(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value, (void)param;
    avr_adc_mux_t input = adc->muxmode[avr_regbit_get_array(board.avr, adc->mux, ARRAY_SIZE(adc->mux))];
    double count = measured_volts() / reference_volts() * (input.kind == ADC_MUX_DIFF ? 512 : 1024);
    if (input.kind == ADC_MUX_DIFF)
        result = (unsigned)(int)(count < -512 ? -512 : count > 511 ? 511 : count) & 0x3ff;
    else
        result = count < 0 ? 0 : count > FULL_SCALE ? FULL_SCALE : (unsigned)(count + 1e-9);
}

static uint8_t read_result(avr_t *avr, avr_io_addr_t address, void *param) {
    (void)param;
    unsigned value = result << (avr_regbit_get(avr, adc->adlar) ? 6 : 0);
    avr->data[adc->r_adcl] = (uint8_t)value;
    avr->data[adc->r_adch] = (uint8_t)(value >> 8);
    return avr->data[address];
}

void adc_start(void) {
    for (avr_io_t *io = board.avr->io_port; io; io = io->next)
        if (strcmp(io->kind, "adc") == 0) adc = (avr_adc_t *)io;
    if (!adc) return;
    avr_irq_register_notify(avr_io_getirq(board.avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER), on_start, NULL);
    board.avr->io[AVR_DATA_TO_IO(adc->r_adcl)].r.c = read_result;
    board.avr->io[AVR_DATA_TO_IO(adc->r_adch)].r.c = read_result;
}

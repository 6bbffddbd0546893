/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One USART, accurate to the bit time. It replaces that of the simulator, which has a receive buffer of 64 bytes,
 * 11 bits a byte and no second transmit buffer. A real one works like this:
 *
 *     receive:  line -> shift register -> 2 bytes -> UDR      a frame that finds all three full is lost (DOR)
 *     transmit: UDR -> 1 byte -> shift register -> line       UDRE while that byte is free
 *
 * Bytes arrive no faster than at the bit rate that the sketch has set. Not modeled: a host at another bit rate, frame
 * and parity errors, the ninth bit, synchronous mode.
 */
#include <string.h>

#include <avr_uart.h>

#include "board.h"

/* Two slices at the highest bit rate (2 Mbaud); no board has a larger buffer. */
#define WAITING_ROOM 512
#define RECEIVE_BUFFER 2

static avr_uart_t *uart;
static struct {
    uint8_t byte;
    bool delayed;
} waiting[WAITING_ROOM];
static size_t waiting_first, waiting_count;
static bool receiving;
static uint8_t received[RECEIVE_BUFFER + 1]; /* the last is the shift register */
static int received_count;
static bool shifting, has_next;
static uint8_t shifted, next;
static unsigned long overruns;
static cycles_t overrun_report_due;

static cycles_t bit_cycles(void) {
    const uint8_t *data = board.avr->data;
    unsigned divisor = data[uart->ubrrl.reg] | (data[uart->ubrrh.reg] & 0x0f) << 8;
    return (cycles_t)(divisor + 1) * (avr_regbit_get(board.avr, uart->u2x) ? 8 : 16);
}

static cycles_t frame_cycles(void) {
    static const uint8_t data_bits[8] = {5, 6, 7, 8, 8, 8, 8, 9};
    avr_t *avr = board.avr;
    unsigned size = avr_regbit_get(avr, uart->ucsz) | avr_regbit_get(avr, uart->ucsz2) << 2;
    bool parity = avr->data[uart->r_ucsrc] & 0x20;
    return bit_cycles() * (1u + data_bits[size] + parity + 1u + avr_regbit_get(avr, uart->usbs));
}

/* Cancels a pending interrupt whose condition has ended; the simulator has no function for it. */
static void withdraw(avr_int_vector_t *vector) {
    avr_int_pending_t *queue = &board.avr->interrupts.pending;
    uint16_t mask = avr_int_pending_fifo_size - 1, kept = queue->read;
    if (!vector->pending) return;
    vector->pending = 0;
    for (uint16_t i = queue->read; i != queue->write; i = (i + 1) & mask)
        if (queue->buffer[i] != vector) {
            queue->buffer[kept] = queue->buffer[i];
            kept = (kept + 1) & mask;
        }
    queue->write = kept;
    if (queue->read == queue->write && board.avr->interrupt_state > 0) board.avr->interrupt_state = 0;
}

/* RXC and UDRE request their interrupt as long as they are set. */
static void set_level(avr_int_vector_t *vector, bool is_set) {
    uint8_t *flags = &board.avr->data[vector->raised.reg];
    uint8_t mask = (uint8_t)(1 << vector->raised.bit);
    if (is_set) {
        *flags |= mask;
        if (avr_regbit_get(board.avr, vector->enable)) avr_raise_interrupt(board.avr, vector);
    } else {
        *flags &= (uint8_t)~mask;
        withdraw(vector);
    }
}

static void update_levels(void) {
    set_level(&uart->rxc, received_count > 0);
    set_level(&uart->udrc, !has_next);
}

static void on_handler_end(struct avr_irq_t *irq, uint32_t running, void *param) {
    (void)irq, (void)param;
    if (!running) update_levels();
}

static cycles_t on_sent(avr_t *avr, cycles_t when, void *param) {
    (void)param;
    link_send(shifted);
    shifting = false;
    if (!has_next) {
        avr_raise_interrupt(avr, &uart->txc);
        return 0;
    }
    shifted = next;
    shifting = true;
    has_next = false;
    update_levels();
    return when + frame_cycles();
}

static void write_data(avr_t *avr, avr_io_addr_t address, uint8_t byte, void *param) {
    (void)address, (void)param;
    if (!avr_regbit_get(avr, uart->txen)) return;
    if (!shifting) {
        shifting = true;
        shifted = byte;
        avr_cycle_timer_register(avr, frame_cycles(), on_sent, NULL);
    } else if (!has_next) {
        has_next = true;
        next = byte;
        update_levels();
    }
}

static cycles_t on_received(avr_t *avr, cycles_t when, void *param);

static void receive_next(cycles_t from) {
    if (receiving || waiting_count == 0 || !board.powered) return;
    receiving = true;
    cycles_t wait = waiting[waiting_first].delayed ? faults_delay_cycles(TO_BOARD) : 0;
    cycles_t due = from + wait + frame_cycles();
    avr_cycle_timer_register(board.avr, due - board.avr->cycle, on_received, NULL);
}

/* Reports bytes that were lost because the program did not read them; called between slices. */
void uart_report_overruns(void) {
    /* One event every tenth of a second shows as much as a hundred. */
    if (!overruns || board.avr->cycle < overrun_report_due) return;
    event_begin("overrun");
    event_int("lost_bytes", (long long)overruns);
    event_end();
    overruns = 0;
    overrun_report_due = board.avr->cycle + 100 * CYCLES_PER_MS;
}

static cycles_t on_received(avr_t *avr, cycles_t when, void *param) {
    (void)param;
    uint8_t byte = waiting[waiting_first].byte;
    waiting_first = (waiting_first + 1) % WAITING_ROOM;
    waiting_count--;
    receiving = false;
    if (avr_regbit_get(avr, uart->rxen)) {
        if (received_count <= RECEIVE_BUFFER) {
            received[received_count++] = byte;
        } else {
            avr->data[uart->dor.reg] |= (uint8_t)(1 << uart->dor.bit);
            overruns++;
        }
        update_levels();
    }
    receive_next(when);
    return 0;
}

static uint8_t read_data(avr_t *avr, avr_io_addr_t address, void *param) {
    (void)address, (void)param;
    uint8_t byte = received[0];
    if (received_count > 0) {
        received_count--;
        memmove(received, received + 1, RECEIVE_BUFFER);
    }
    avr->data[uart->dor.reg] &= (uint8_t)~(1 << uart->dor.bit);
    update_levels();
    return byte;
}

static void write_status(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    (void)param;
    uint8_t writable = (uint8_t)(1 << uart->u2x.bit | 1); /* and MPCM */
    avr->data[address] = (uint8_t)((avr->data[address] & ~writable) | (value & writable));
    if (value & 1 << uart->txc.raised.bit) {
        avr->data[address] &= (uint8_t)~(1 << uart->txc.raised.bit);
        withdraw(&uart->txc);
    }
}

static void write_control(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    (void)param;
    avr->data[address] = value;
    if (!avr_regbit_get(avr, uart->rxen)) {
        received_count = 0;
        avr->data[uart->dor.reg] &= (uint8_t)~(1 << uart->dor.bit);
    }
    if (!avr_regbit_get(avr, uart->rxc.enable)) withdraw(&uart->rxc);
    if (!avr_regbit_get(avr, uart->udrc.enable)) withdraw(&uart->udrc);
    if (avr_regbit_get(avr, uart->txc.enable) && avr_regbit_get(avr, uart->txc.raised))
        avr_raise_interrupt(avr, &uart->txc);
    update_levels();
}

static void on_simulator_reset(struct avr_io_t *io) { (void)io; }

void uart_reset(void) {
    avr_t *avr = board.avr;
    avr_cycle_timer_cancel(avr, on_sent, NULL);
    avr_cycle_timer_cancel(avr, on_received, NULL);
    receiving = shifting = has_next = false;
    received_count = 0;
    if (!board.powered) waiting_count = 0;
    avr->data[uart->r_ucsra] = 0;
    avr->data[uart->r_ucsrb] = 0;
    avr->data[uart->r_ucsrc] = 0x06; /* 8N1 */
    avr->data[uart->ubrrl.reg] = avr->data[uart->ubrrh.reg] = 0;
    update_levels();
    receive_next(avr->cycle);
}

size_t uart_room(void) { return WAITING_ROOM - waiting_count; }

void uart_receive(uint8_t byte, bool delayed) {
    size_t last = (waiting_first + waiting_count) % WAITING_ROOM;
    if (waiting_count == WAITING_ROOM) return;
    waiting[last].byte = byte;
    waiting[last].delayed = delayed;
    waiting_count++;
    receive_next(board.avr->cycle);
}

static avr_uart_t *quiet_all_but(char name) {
    avr_uart_t *found = NULL;
    for (avr_io_t *io = board.avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "uart") != 0) continue;
        avr_uart_t *each = (avr_uart_t *)io;
        each->flags = 0; /* the simulator must neither print the bytes nor sleep */
        if (each->name == name) found = each;
    }
    return found;
}

static void replace_handlers(avr_io_addr_t address, avr_io_read_t read, avr_io_write_t write) {
    avr_io_addr_t io = AVR_DATA_TO_IO(address);
    board.avr->io[io].r.c = read;
    board.avr->io[io].r.param = NULL;
    board.avr->io[io].w.c = write;
    board.avr->io[io].w.param = NULL;
}

bool uart_start(char name) {
    uart = quiet_all_but(name);
    if (!uart) return false;
    uart->io.reset = on_simulator_reset;
    replace_handlers(uart->r_udr, read_data, write_data);
    replace_handlers(uart->r_ucsra, NULL, write_status);
    replace_handlers(uart->r_ucsrb, NULL, write_control);
    replace_handlers(uart->ubrrl.reg, NULL, NULL);
    avr_irq_register_notify(&uart->rxc.irq[AVR_INT_IRQ_RUNNING], on_handler_end, NULL);
    avr_irq_register_notify(&uart->udrc.irq[AVR_INT_IRQ_RUNNING], on_handler_end, NULL);
    return true;
}

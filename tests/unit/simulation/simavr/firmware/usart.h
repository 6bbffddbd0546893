/* The board's UART, by polling: USART0, or USART1 on a chip without it. BAUD is the bit rate. */
#ifndef USART_H
#define USART_H

#include <avr/interrupt.h>
#include <avr/io.h>

#ifndef BAUD
#define BAUD 115200UL
#endif
#ifndef UDR0
#define UDR0 UDR1
#define UCSR0A UCSR1A
#define UCSR0B UCSR1B
#define UCSR0C UCSR1C
#define UBRR0 UBRR1
#define U2X0 U2X1
#define RXEN0 RXEN1
#define TXEN0 TXEN1
#define RXC0 RXC1
#define UDRE0 UDRE1
#define UDRIE0 UDRIE1
#define RXCIE0 RXCIE1
#define TXC0 TXC1
#define TXCIE0 TXCIE1
#define DOR0 DOR1
#define USART_RX_vect USART1_RX_vect
#define USART_TX_vect USART1_TX_vect
#define USART_UDRE_vect USART1_UDRE_vect
#endif
#ifdef USART0_RX_vect
#define USART_RX_vect USART0_RX_vect
#define USART_TX_vect USART0_TX_vect
#define USART_UDRE_vect USART0_UDRE_vect
#endif

static inline void usart_start(void) {
    UBRR0 = (F_CPU / 4 / BAUD - 1) / 2;
    UCSR0A = 1 << U2X0;
    UCSR0B = 1 << RXEN0 | 1 << TXEN0;
}

static inline void usart_send(uint8_t byte) {
    while (!(UCSR0A & 1 << UDRE0)) continue;
    UDR0 = byte;
}

static inline uint8_t usart_receive(void) {
    while (!(UCSR0A & 1 << RXC0)) continue;
    return UDR0;
}

#endif

/* Receives bytes that count up, by interrupt or polling, and sends others; counts the errors. */
#include "usart.h"

volatile uint16_t received, wrong, overruns;
static uint8_t expected;
static volatile uint8_t sent;

static inline void take(void) {
    if (UCSR0A & 1 << DOR0) overruns++;
    uint8_t byte = UDR0;
    if (byte != expected) wrong++;
    expected = byte + 1;
    received++;
}

ISR(USART_RX_vect) { take(); }

ISR(USART_UDRE_vect) { UDR0 = sent++; }

int main(void) {
    usart_start();
#ifdef INTERRUPTS
    UCSR0B |= 1 << RXCIE0 | 1 << UDRIE0;
    sei();
    for (;;) continue;
#else
    for (;;) {
        if (UCSR0A & 1 << RXC0) take();
        if (UCSR0A & 1 << UDRE0) UDR0 = sent++;
    }
#endif
}

/* Sends "ab", and counts the interrupts at the end of transmission. */
#include "usart.h"

volatile uint8_t ends;

ISR(USART_TX_vect) { ends++; }

int main(void) {
    usart_start();
    UCSR0B |= 1 << TXCIE0;
    sei();
    usart_send('a');
    usart_send('b');
    for (;;) continue;
}

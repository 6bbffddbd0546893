/* Checks its UART every 20 ms, and then sends all received bytes back. */
#include <util/delay.h>

#include "usart.h"

volatile uint8_t lost;

int main(void) {
    usart_start();
    for (;;) {
        _delay_ms(20);
        while (UCSR0A & 1 << RXC0) {
            if (UCSR0A & 1 << DOR0) lost = 1;
            usart_send(UDR0);
        }
    }
}

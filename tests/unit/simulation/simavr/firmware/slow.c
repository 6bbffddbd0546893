/* Looks at its UART once in 20 ms, then takes all that is there and sends it back. */
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

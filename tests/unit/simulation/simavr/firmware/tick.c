/* Counts, and sends the count every 5 ms. */
#include <util/delay.h>

#include "usart.h"

volatile uint8_t ticks;

int main(void) {
    usart_start();
    for (;;) {
        _delay_ms(5);
        usart_send(++ticks);
    }
}

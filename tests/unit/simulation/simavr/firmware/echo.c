/* Sends back each byte. */
#include "usart.h"

int main(void) {
    usart_start();
    for (;;) usart_send(usart_receive());
}

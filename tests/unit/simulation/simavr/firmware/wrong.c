/* The received byte chooses a fault. The starts are counted in memory that no start clears. */
#include <stdlib.h>

#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/delay.h>

#include "usart.h"

volatile uint8_t starts __attribute__((section(".noinit")));
volatile uint8_t cause;
volatile uint8_t fence[4];
volatile uint8_t buffer[8];
volatile uint8_t too_many = 10;

static uint8_t dig(uint8_t depth) {
    volatile uint8_t pad[16];
    for (uint8_t i = 0; i < sizeof pad; i++) pad[i] = 0xa5 ^ depth ^ i;
    return depth ? dig(depth - 1) + pad[3] : pad[0];
}

static char *kept;

static char *fill(char *block, size_t size) {
    for (size_t i = 0; block && i < size; i++) ((volatile char *)block)[i] = (char)(i ^ 0x5a);
    return block;
}

static void empty(void) {}

int main(void) {
    cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
    starts++;
    usart_start();
    for (;;) switch (usart_receive()) {
        case 'j': ((void (*)(void))0)(); break;
        case 'o': ((void (*)(void))0x3000)(); break;
        case 'i': asm volatile(".word 0x9404"); break;
        case 'w': *(volatile uint8_t *)0x4000 = 1; break;
        case 'r': cause = *(volatile uint8_t *)0x4000; break;
        case 'b': for (uint8_t i = 0; i < too_many; i++) buffer[i] = i; break;
        case 'f': fence[0] = 1; break;
        case 'd': buffer[0] = dig(20); break;
        case 'D': buffer[0] = dig(72); break;
        case 'x': buffer[0] = dig(150); break;
        case 'g': wdt_enable(WDTO_15MS); for (;;) continue;
        case 's': cli(); sleep_enable(); sleep_cpu(); break;
        case 'm': free(fill(malloc(700), 700)); break;
        case 'M': kept = fill(malloc(700), 700); break;
        case 'c': empty(); break;
        }
}

/* Regions of known length between markers. */
#include <avr/io.h>

int main(void) {
    GPIOR2 = 0; /* an end without a beginning */
    asm volatile("ldi r24, 1\n ldi r25, 0\n"
                 "out %0, r24\n out %0, r25\n"
                 "out %0, r24\n nop\n nop\n nop\n nop\n nop\n out %0, r25\n" ::"I"(_SFR_IO_ADDR(GPIOR2))
                 : "r24", "r25");
    for (;;) continue;
}

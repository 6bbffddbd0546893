/* The start of a program on qemu's board lx60 with an lx106, the processor core of the ESP8266. */
  .section .text.start, "ax"
  .literal_position
  .literal stack, stack_top
  .literal run, runProgram
  .align 4
  .global startProgram
startProgram:
  l32r a1, stack
  l32r a0, run
  callx0 a0
1:
  j 1b

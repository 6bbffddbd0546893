"""A Pico's pins, which the unix port does not have: what a program does with them is printed on standard
error.
"""

import sys
from struct import pack_into


def report(*values):
    print(*values, file=sys.stderr)


class Pin:
    IN, OUT = 0, 1

    def __init__(self, name, mode=IN):
        self.name = name
        self._value = 0

    def value(self, value=None):
        if value is not None and value != self._value:
            self._value = value
            report("pin", self.name, value)
        return self._value


class PWM:
    def __init__(self, pin):
        self._pin = pin

    def freq(self, hz):
        report("frequency", self._pin.name, hz)

    def duty_ns(self, duty_ns):
        report("pulse", self._pin.name, duty_ns)


class I2C:
    """An MPU-6050 that is level and turns about its z axis at 250 degrees a second; unplugged at first."""

    def __init__(self, number, sda, scl, freq):
        self._is_plugged = False

    def writeto_mem(self, address, register, data):
        if not self._is_plugged:
            self._is_plugged = True
            raise OSError(5)

    def readfrom_mem_into(self, address, register, buffer):
        if (address, register) != (0x68, 0x3B):
            raise OSError(5)
        pack_into(">7h", buffer, 0, 0, 0, 8192, 0, 0, 0, 16384)


def time_pulse_us(pin, level, timeout_us):
    """Return the echo of a wall at half a meter."""
    return 2915

"""CircuitPython's counter of milliseconds, close to its end: it starts at 0 again after 0.5 s."""

import time

_PERIOD = 1 << 29
_FIRST = _PERIOD - 500
_began_s = time.monotonic()


def ticks_ms():
    return (_FIRST + int((time.monotonic() - _began_s) * 1000)) % _PERIOD

"""The board's milliseconds: MicroPython's, or CircuitPython's."""

try:
    from time import sleep_ms, ticks_diff, ticks_ms
except ImportError:
    import time

    from supervisor import ticks_ms

    # CircuitPython's counter starts at 0 again after this number of ms, which is 6 days.
    _PERIOD = 1 << 29
    _HALF = _PERIOD // 2

    def ticks_diff(later, earlier):
        """Return the number of ms between two values of the counter, which must be less than 3 days apart."""
        return ((later - earlier + _HALF) & (_PERIOD - 1)) - _HALF

    def sleep_ms(pause_ms):
        """Wait for `pause_ms`."""
        time.sleep(pause_ms / 1000)


__all__ = ("sleep_ms", "ticks_diff", "ticks_ms")

"""A UART: MicroPython's machine.UART, CircuitPython's busio.UART, or its second USB port, usb_cdc.data."""


class Uart:
    """Bytes of a UART. `uart` has `any()` or `in_waiting`, `readinto(buffer)` and `write(buffer)`."""

    def __init__(self, uart):
        self._uart = uart
        self._has_any = hasattr(uart, "any")

    def read(self, view, at):
        """Read the available bytes; return their number."""
        uart = self._uart
        count = uart.any() if self._has_any else uart.in_waiting
        if not count:
            return 0
        return uart.readinto(view[at : at + count]) or 0

    def write(self, view):
        """Return how many bytes were accepted."""
        return self._uart.write(view) or 0

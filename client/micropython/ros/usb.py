"""The board's USB port."""


def usb_hardware():
    """Return the hardware for USB: on CircuitPython its second port, usb_cdc.data, if boot.py enables it."""
    try:
        import usb_cdc
    except ImportError:
        return UsbSerial()
    from ros.uart import Uart

    return Uart(usb_cdc.data or usb_cdc.console)


class UsbSerial:
    """MicroPython's standard input and output, without its meaning of Ctrl-C, a byte that messages have."""

    def __init__(self):
        import select
        import sys

        import micropython

        micropython.kbd_intr(-1)
        self._input = sys.stdin.buffer
        self._output = sys.stdout.buffer
        self._poll = select.poll()
        self._poll.register(self._input, select.POLLIN)
        # Standard input waits until it has filled a buffer.
        self._byte = memoryview(bytearray(1))

    def read(self, view, at):
        """Read what is there; return the number of bytes."""
        begin = at
        poll = self._poll
        byte = self._byte
        while at < len(view):
            for _ in poll.ipoll(0):
                break
            else:
                break
            if not self._input.readinto(byte):
                break
            view[at] = byte[0]
            at += 1
        return at - begin

    def write(self, view):
        """Return how many bytes were accepted."""
        return self._output.write(view) or 0

"""The board's USB port."""

_CTRL_C = 3


def usb_hardware():
    """Return the hardware for USB: on CircuitPython its second port, usb_cdc.data, if boot.py enables it."""
    try:
        import usb_cdc
    except ImportError:
        return UsbSerial()
    from ros.uart import Uart

    port = usb_cdc.data or usb_cdc.console
    # Otherwise, a write blocks until a host reads.
    port.write_timeout = 0
    return Uart(port)


class UsbSerial:
    """MicroPython's standard input and output.

    The bytes of messages may contain a Ctrl-C, so only a Ctrl-C between two frames stops the program.
    """

    def __init__(self):
        import select
        import sys

        from micropython import kbd_intr

        self._set_interrupt = kbd_intr
        self._set_interrupt(-1)
        self._input = sys.stdin.buffer
        self._output = sys.stdout.buffer
        self._poll = select.poll()
        self._poll.register(sys.stdin, select.POLLIN)
        # Only one byte is read at a time: standard input blocks until it has filled the buffer.
        self._byte = memoryview(bytearray(1))

    def read(self, view, at):
        """Read the available bytes; return their number."""
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

    def interrupt(self):
        """Stop the program, so that a new one can be copied to the board. Raises KeyboardInterrupt."""
        self._set_interrupt(_CTRL_C)
        raise KeyboardInterrupt

    def write(self, view):
        """Return how many bytes were accepted."""
        return self._output.write(view) or 0

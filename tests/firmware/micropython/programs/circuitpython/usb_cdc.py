"""CircuitPython's second USB port: the terminal in the program's second argument."""

import select
import sys
import tty


class _Port:
    # As on CircuitPython: a write waits until a host has read everything.
    write_timeout = None

    def __init__(self, path):
        self._file = open(path, "r+b", 0)
        tty.setraw(self._file)
        self.readinto = self._file.readinto

    @property
    def in_waiting(self):
        return 1 if select.select([self._file], [], [], 0)[0] else 0

    def write(self, data):
        assert self.write_timeout == 0, "a write may wait without end"
        return self._file.write(data)


console = None
data = _Port(sys.argv[2]) if sys.argv[1] == "usb" else None

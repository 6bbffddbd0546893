"""A terminal with the methods of machine.UART, which the unix port does not have."""

import select
import termios


class TtyUart:
    def __init__(self, path):
        self._file = open(path, "r+b", 0)
        termios.setraw(self._file.fileno())
        self._poll = select.poll()
        self._poll.register(self._file, select.POLLIN)

    def any(self):
        return 1 if self._poll.poll(0) else 0

    def readinto(self, buffer):
        return self._file.readinto(buffer)

    def write(self, buffer):
        return self._file.write(buffer)

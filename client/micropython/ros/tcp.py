"""A TCP connection to the host, restored whenever it is lost."""

from ros.ticks import ticks_diff, ticks_ms

# A restarted host is found within a second.
_PAUSE_MS = 500
# A host on a local network answers sooner. The program is blocked meanwhile.
_CONNECT_S = 2


class Tcp:
    """A connection to the bridge at `host`, a name or an address, and `port`. The board's network must be up.

    `sockets` is the module socket by default; on CircuitPython it is a socketpool.SocketPool.
    """

    def __init__(self, host, port=11411, sockets=None):
        if sockets is None:
            import socket as sockets
        self._sockets = sockets
        self._host = host
        self._port = port
        self._socket = None
        self._changed = False
        self._tried_ms = ticks_ms() - _PAUSE_MS

    def relinked(self):
        """Return whether the link was lost or made since the last call."""
        changed = self._changed
        self._changed = False
        return changed

    def relink(self):
        """End the connection, and make a new one."""
        if self._socket is not None:
            self._close()

    def read(self, view, at):
        """Read the available bytes; return their number."""
        # The node must learn of a new link before it reads the first byte.
        if self._changed:
            return 0
        if self._socket is None:
            self._connect()
            return 0
        try:
            count = self._receive(view[at:])
        except OSError as error:
            return self._wait_or_close(error)
        if count == 0:
            self._close()
        return count or 0

    def write(self, view):
        """Return how many bytes were accepted."""
        if self._socket is None or self._changed:
            return 0
        try:
            return self._socket.send(view) or 0
        except OSError as error:
            return self._wait_or_close(error)

    def _connect(self):
        if ticks_diff(ticks_ms(), self._tried_ms) < _PAUSE_MS:
            return
        made = None
        try:
            address = self._sockets.getaddrinfo(self._host, self._port)[0][-1]
            made = self._sockets.socket()
            made.settimeout(_CONNECT_S)
            made.connect(address)
            made.setblocking(False)
        except OSError:
            if made is not None:
                made.close()
        else:
            self._socket = made
            # The function's name in CircuitPython, and in MicroPython.
            self._receive = made.recv_into if hasattr(made, "recv_into") else made.readinto
            self._changed = True
        self._tried_ms = ticks_ms()

    def _wait_or_close(self, error):
        # EAGAIN: nothing to read, or no room to write.
        if error.errno != 11:
            self._close()
        return 0

    def _close(self):
        self._socket.close()
        self._socket = None
        self._changed = True
        self._tried_ms = ticks_ms()

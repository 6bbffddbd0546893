"""The received bytes that are not handled yet."""

from ros.wire import Reader

_SYNC = 0xFF
_VERSION = 0xFE
# Sync, version, length (2), length checksum, topic id (2), and the checksum after the payload.
_HEADER_BYTES = 7
OVERHEAD_BYTES = 8
_CTRL_C = 3


class ReceiveWindow:
    """Finds frames, and opens the payload of the last one in `reader`.

    If a check fails, the first byte is dropped and the rest is checked again: a valid frame may follow or be
    inside a damaged one.
    """

    def __init__(self, largest_payload):
        self.largest_payload = largest_payload
        self._bytes = bytearray(largest_payload + OVERHEAD_BYTES)
        self._view = memoryview(self._bytes)
        self._begin = self._end = 0
        self._foreign = False
        self.reader = Reader(self._bytes)
        # The number of frames that started but did not become a message, and of messages that were not sent.
        self.dropped = 0
        # Whether a Ctrl-C arrived between two frames. After a damaged frame, such a byte is ignored: it may
        # belong to the frame.
        self.interrupted = False
        self._in_step = True

    def empty(self):
        """Return whether all bytes are handled."""
        return self._begin == self._end

    def fill(self, hardware):
        """Read bytes from the hardware into the free room; return their number."""
        if self._begin == self._end:
            self._begin = self._end = 0
        elif self._end == len(self._bytes):
            have = self._end - self._begin
            self._bytes[:have] = self._bytes[self._begin : self._end]
            self._begin, self._end = 0, have
        if self._end == len(self._bytes):
            return 0
        count = hardware.read(self._view, self._end)
        self._end += count
        return count

    def next(self):
        """Return the topic id of the next whole frame, and open its payload; -1 if there is none yet."""
        data = self._bytes
        while self._begin < self._end:
            at = self._begin
            have = self._end - at
            if data[at] == _SYNC:
                if have < 2:
                    return -1
                if data[at + 1] != _VERSION:
                    self._foreign = True
                else:
                    if have < OVERHEAD_BYTES:
                        return -1
                    end = self._frame_end(at)
                    if end > self._end:
                        return -1
                    self._in_step = end > 0 and sum(self._view[at + 5 : end]) & 255 == 255
                    if self._in_step:
                        self._begin = end
                        self.reader.at = at + _HEADER_BYTES
                        self.reader.end = end - 1
                        return data[at + 5] | data[at + 6] << 8
            elif data[at] == _CTRL_C and self._in_step:
                self.interrupted = True
            self.drop()
        return -1

    def _frame_end(self, at):
        """Return the end of a frame, from its header; 0 for a damaged header, or a frame that is too long."""
        data = self._bytes
        length = data[at + 2] | data[at + 3] << 8
        if (data[at + 2] + data[at + 3] + data[at + 4]) & 255 != 255 or length > self.largest_payload:
            return 0
        return at + length + OVERHEAD_BYTES

    def drop(self):
        """Drop the first byte."""
        if self._bytes[self._begin] == _SYNC:
            self.dropped += 1
        self._begin += 1

    def forget(self):
        """Drop all bytes."""
        self._begin = self._end

    def read_foreign(self):
        """Return whether bytes dropped since the last call were the start of a frame of another version."""
        foreign = self._foreign
        self._foreign = False
        return foreign

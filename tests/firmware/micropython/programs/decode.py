"""Decodes each line of standard input, a stream in hexadecimal, and prints its topic ids and payloads."""

import sys
from binascii import hexlify, unhexlify

from ros.receive_window import ReceiveWindow


class Line:
    """Hardware that returns these bytes, in pieces of `piece_bytes`."""

    def __init__(self, data, piece_bytes):
        self._data = memoryview(data)
        self._at = 0
        self._piece_bytes = piece_bytes

    def read(self, view, at):
        count = min(self._piece_bytes, len(view) - at, len(self._data) - self._at)
        view[at : at + count] = self._data[self._at : self._at + count]
        self._at += count
        return count


def decode(data, piece_bytes):
    window = ReceiveWindow(1024)
    line = Line(data, piece_bytes)
    found = []
    while True:
        topic_id = window.next()
        if topic_id >= 0:
            reader = window.reader
            found.append((topic_id, hexlify(reader.buffer[reader.at : reader.end]).decode()))
        elif not window.fill(line):
            if window.empty():
                return found
            # The rest of the frame is missing.
            window.drop()


for text in sys.stdin:
    data = unhexlify(text.strip())
    found = decode(data, 512)
    if decode(data, 1) != found:
        found = ["pieces differ"]
    print(" ".join(str(topic_id) + ":" + payload for topic_id, payload in found))

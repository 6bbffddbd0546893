"""Writes and reads messages in ROS 1 serialization, in buffers of a fixed size."""

from array import array
from struct import pack_into, unpack_from

# The limit of elements without bytes, as in std_msgs/Empty[]: otherwise, an array of four bytes on the line
# could fill the memory.
_MAX_EMPTY = 255


class MisfitError(ValueError):
    """A message does not fit in the buffer, or the bytes are not a message of the expected type."""


class Writer:
    """Writes a message to a buffer of `size` bytes."""

    def __init__(self, size):
        self.buffer = bytearray(size)
        self.view = memoryview(self.buffer)
        self.at = 0

    def room(self, count):
        """Return where the next `count` bytes go. Raises MisfitError if the buffer is full."""
        at = self.at
        if at + count > len(self.buffer):
            raise MisfitError("message too long")
        self.at = at + count
        return at

    def number(self, code, value):
        """Write one number; `code` is that of struct."""
        pack_into("<" + code, self.buffer, self.room(_SIZES[code]), value)

    def bytes(self, data, length=None):
        """Write uint8[].

        Here and in the other functions for arrays, `length` is the length of an array of a fixed length.
        Raises ValueError if the array has another length.
        """
        self._count(data, length)
        at = self.room(len(data))
        self.view[at : self.at] = bytes(data)

    def string(self, text):
        """Write a string, given as str or as bytes."""
        self.bytes(text.encode() if isinstance(text, str) else text)

    def array(self, code, values, length=None):
        """Write an array of numbers; the code ? is that of bool."""
        if code == "?":
            code = "B"
            values = [1 if value else 0 for value in values]
        self._count(values, length)
        count = len(values)
        pack_into("<" + str(count) + code, self.buffer, self.room(count * _SIZES[code]), *values)

    def strings(self, texts, length=None):
        """Write an array of strings."""
        self._count(texts, length)
        for each in texts:
            self.string(each)

    def messages(self, messages, length=None):
        """Write an array of messages."""
        self._count(messages, length)
        for each in messages:
            each.serialize(self)

    def _count(self, values, length):
        if length is None:
            self.number("I", len(values))
        elif len(values) != length:
            raise ValueError("an array has " + str(len(values)) + " elements, not " + str(length))


class Reader:
    """Reads a message from the bytes between `at` and `end` of a buffer."""

    def __init__(self, buffer):
        self.buffer = buffer
        self._view = memoryview(buffer)
        self.at = self.end = 0

    def skip(self, count):
        """Return where the next `count` bytes are. Raises MisfitError if there are fewer."""
        at = self.at
        if at + count > self.end:
            raise MisfitError("message too short")
        self.at = at + count
        return at

    def number(self, code):
        """Read one number; `code` is that of struct."""
        return unpack_from("<" + code, self.buffer, self.skip(_SIZES[code]))[0]

    def bytes(self, length=None):
        """Read uint8[]."""
        at = self.skip(self._count(length, 1))
        return bytes(self._view[at : self.at])

    def string(self):
        """Read a string; if it is not UTF-8, return its bytes."""
        data = self.bytes()
        try:
            return str(data, "utf-8")
        except UnicodeError:
            return data

    def array(self, code, length=None):
        """Read an array of numbers; the code ? is that of bool."""
        if code == "?":
            return [each != 0 for each in self.bytes(length)]
        size = _SIZES[code]
        count = self._count(length, size)
        return array(code, bytes(self._view[self.skip(count * size) : self.at]))

    def strings(self, length=None):
        """Read an array of strings."""
        return [self.string() for _ in range(self._count(length, 4))]

    def messages(self, make, size, length=None):
        """Read an array of messages of the class `make`, of at least `size` bytes each."""
        found = [make() for _ in range(self._count(length, size))]
        for each in found:
            each.deserialize(self)
        return found

    def finish(self):
        """Check that all bytes are read. Raises MisfitError if not."""
        if self.at != self.end:
            raise MisfitError("message too long")

    def _count(self, length, size):
        count = self.number("I") if length is None else length
        if count * size > self.end - self.at or (size == 0 and count > _MAX_EMPTY):
            raise MisfitError("array too long")
        return count


_SIZES = {"b": 1, "B": 1, "h": 2, "H": 2, "i": 4, "I": 4, "q": 8, "Q": 8, "f": 4, "d": 8}

"""The common base of the generated messages."""


class Message:
    """A message, a request or a response. Its class has `_type`, `_md5sum`, `serialize` and `deserialize`."""

    def __eq__(self, other):
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __repr__(self):
        return self._type + repr(self.__dict__)


def repeat(make, count):
    """Return a list of new messages, for an array of a fixed length."""
    return [make() for _ in range(count)]

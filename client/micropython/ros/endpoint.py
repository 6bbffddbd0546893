"""The common base of publishers, subscribers and services."""


class Endpoint:
    """A topic or service: its name, the class of its messages or of the service, and its topic ids.

    A node handle assigns the ids.
    """

    # The number of its topic ids. A service receives on `id`, and sends on the next one.
    id_count = 1

    def __init__(self, topic, type_class):
        self.topic = topic
        self._class = type_class
        self._nh = None
        self.id = 0

    def attach(self, node_handle, first_id):
        """For the node handle: assign the node handle and the ids, which count up from `first_id`."""
        self._nh = node_handle
        self.id = first_id

    def read(self, message_class, reader):
        """Read a message from all bytes of the reader. Raises MisfitError if they are not such a message."""
        message = message_class()
        message.deserialize(reader)
        reader.finish()
        return message

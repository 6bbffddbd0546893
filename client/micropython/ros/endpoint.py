"""The common base of publishers, subscribers and services."""


class Endpoint:
    """A name, the class of its messages or its service, and the topic ids that a node handle gave it."""

    # A service receives on `id`, and sends on the next one.
    id_count = 1

    def __init__(self, topic, type_class):
        self.topic = topic
        self._class = type_class
        self._nh = None
        self.id = 0

    def attach(self, node_handle, first_id):
        """For the node handle: use it, and these ids."""
        self._nh = node_handle
        self.id = first_id

    def read(self, message_class, reader):
        """Return a message that fills all bytes. Raises MisfitError."""
        message = message_class()
        message.deserialize(reader)
        reader.finish()
        return message

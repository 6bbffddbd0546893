"""`Subscriber`."""

from ros.endpoint import Endpoint
from ros.topic_id import ID_SUBSCRIBER


class Subscriber(Endpoint):
    """Calls `callback(message)` for each message of a topic, once it is subscribed to."""

    def __init__(self, topic, message_class, callback):
        super().__init__(topic, message_class)
        self._callback = callback

    def announce(self):
        """For the node handle: announce the topic to the host."""
        self._nh.announce(ID_SUBSCRIBER, self.id, self.topic, self._class)

    def receive(self, reader):
        """For the node handle: handle a message. Raises MisfitError."""
        message = self.read(self._class, reader)
        self._callback(message)

"""`Publisher`."""

from ros.endpoint import Endpoint
from ros.topic_id import ID_PUBLISHER


class Publisher(Endpoint):
    """Sends messages of one class to a topic, once it is advertised."""

    def announce(self):
        """For the node handle: announce the topic to the host."""
        self._nh.announce(ID_PUBLISHER, self.id, self.topic, self._class)

    def publish(self, message):
        """Send a message.

        Returns the number of bytes sent; 0 if the topic is not advertised or no host is connected; -1 if the
        message is too long or was not accepted by the line. Raises TypeError for a message of another class.
        """
        if not isinstance(message, self._class):
            raise TypeError(self.topic + " has messages of " + self._class._type)
        return self._nh.send(self.id, message) if self._nh else 0

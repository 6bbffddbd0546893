"""`Publisher`."""

from ros.endpoint import Endpoint
from ros.topic_id import ID_PUBLISHER


class Publisher(Endpoint):
    """Sends messages of one class to a topic, once it is advertised."""

    def announce(self):
        """For the node handle: announce the topic to the host."""
        self._nh.announce(ID_PUBLISHER, self.id, self.topic, self._class)

    def publish(self, message):
        """Send a message; return its bytes.

        0 without a host, -1 if it is too long or the line did not accept it.
        Raises TypeError for a message of another class.
        """
        if not isinstance(message, self._class):
            raise TypeError(self.topic + " has messages of " + self._class._type)
        return self._nh.send(self.id, message) if self._nh else 0

"""`ServiceClient`."""

from ros.endpoint import Endpoint
from ros.topic_id import ID_SERVICE_CLIENT


class ServiceClient(Endpoint):
    """Calls a service of the graph, and waits for its response. Other callbacks run meanwhile."""

    id_count = 2

    def __init__(self, service, service_class):
        super().__init__(service, service_class)
        self._waits = False
        self._response = None

    def announce(self):
        """For the node handle: announce the service to the host."""
        self._nh.announce(ID_SERVICE_CLIENT, self.id + 1, self.topic, self._class.Request)
        self._nh.announce(ID_SERVICE_CLIENT + 1, self.id, self.topic, self._class.Response)

    def call(self, request, timeout_ms=10000):
        """Call the service and return its response.

        Returns None without a host, during another call, or after `timeout_ms`. Raises TypeError for a
        request of another class.
        """
        if not self.begin(request):
            return None
        try:
            self._nh.spin_while(self.is_waiting, timeout_ms)
        finally:
            response = self.end()
        return response

    def begin(self, request):
        """Send a request; return whether it was sent. Raises TypeError for a request of another class."""
        if not isinstance(request, self._class.Request):
            raise TypeError(self.topic + " has requests of " + self._class.Request._type)
        if not self._nh or self._waits or self._nh.send(self.id + 1, request) <= 0:
            return False
        self._waits = True
        self._response = None
        return True

    def is_waiting(self):
        """Return whether the response may still arrive."""
        return self._waits and self._response is None and self._nh.connected()

    def end(self):
        """End the call, and return its response or None; a later response is ignored."""
        self._waits = False
        return self._response

    def receive(self, reader):
        """For the node handle: handle a response. Raises MisfitError."""
        response = self.read(self._class.Response, reader)
        if self._waits and self._response is None:
            self._response = response

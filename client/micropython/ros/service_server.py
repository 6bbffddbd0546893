"""`ServiceServer`."""

from ros.endpoint import Endpoint
from ros.topic_id import ID_SERVICE_SERVER


class ServiceServer(Endpoint):
    """Answers calls of a service: `callback(request, response)` sets the fields of the response."""

    id_count = 2

    def __init__(self, service, service_class, callback):
        super().__init__(service, service_class)
        self._callback = callback

    def announce(self):
        """For the node handle: announce the service to the host."""
        self._nh.announce(ID_SERVICE_SERVER, self.id + 1, self.topic, self._class.Response)
        self._nh.announce(ID_SERVICE_SERVER + 1, self.id, self.topic, self._class.Request)

    def receive(self, reader):
        """For the node handle: handle a request. Raises MisfitError."""
        request = self.read(self._class.Request, reader)
        response = self._class.Response()
        self._callback(request, response)
        self._nh.send(self.id + 1, response)

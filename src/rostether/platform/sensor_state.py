"""The state of a sensor, from the registry's observations; without clock or graph.

init          registered, has not published yet
ready         publishes, or a camera that waits for a subscriber
sleeping      connected, but silent
alert         connected; the sensor reports a problem, or its topic has a wrong type
disconnected  its publisher has ended
lost          not connected for `LOST_S`, or its lease has expired
"""

from __future__ import annotations

from msgspec import Struct

# The states that a sensor with a lease may report.
REPORTED = ("init", "ready", "sleeping", "alert")

# Enough for a sentence with the path of a file.
MAX_STATE_TEXT_CHARACTERS = 300

# A sensor that publishes every second may lose two messages.
SILENT_S = 3.0

# Longer than the restart of a robot's computer.
LOST_S = 60.0


class Condition(Struct):
    """The observations of one sensor; times are seconds of a monotonic clock.

    `lease_until_s` is None for a sensor without a lease; one with a lease reports its state itself.
    """

    since_s: float
    state: str = "init"
    text: str = ""
    is_connected: bool = False
    has_publisher: bool = False
    # What is wrong with the type of a connected sensor without a lease, else empty.
    type_fault: str = ""
    was_connected: bool = False
    left_s: float = 0.0
    last_message_s: float | None = None
    lease_until_s: float | None = None
    instance: str = ""
    reported: str = "init"
    reported_text: str = ""

    def record_connection(self, is_connected: bool, now_s: float) -> None:
        """Record whether the sensor's topic has a publisher now."""
        self.has_publisher = is_connected
        if self.is_connected and not is_connected:
            self.left_s = now_s
        if is_connected and not self.is_connected:
            self.last_message_s = None
        self.is_connected = is_connected
        self.was_connected |= is_connected

    def holds_lease(self, now_s: float) -> bool:
        """Return whether a node holds a valid lease for this sensor."""
        return self.is_connected and self.lease_until_s is not None and now_s < self.lease_until_s

    def update_state(self, is_camera: bool, now_s: float) -> bool:
        """Update the state and its text; return whether either has changed."""
        before = self.state, self.text
        # A message may arrive after the graph has reported the end of its publisher.
        if self.is_connected and not self.has_publisher and self._is_silent(now_s):
            self.record_connection(False, now_s)
        self.state = self._next_state(is_camera, now_s)
        self.text = self.reported_text if self.state == self.reported else ""
        if self.state == "alert" and self.lease_until_s is None:
            self.text = self.type_fault
        if self.state != before[0]:
            self.since_s = now_s
        return (self.state, self.text) != before

    def _next_state(self, is_camera: bool, now_s: float) -> str:
        if self.lease_until_s is not None and now_s >= self.lease_until_s:
            return "lost"
        if not self.is_connected:
            if self.lease_until_s is None and now_s - self.left_s >= LOST_S:
                return "lost"
            return "disconnected" if self.was_connected else "init"
        if self.lease_until_s is not None:
            return self.reported
        if self.type_fault:
            return "alert"
        # A camera publishes only while it has subscribers; the manager does not subscribe to pictures.
        if is_camera:
            return "ready"
        if self.last_message_s is None:
            return "init" if self.state in ("init", "disconnected", "lost") else "sleeping"
        return "sleeping" if self._is_silent(now_s) else "ready"

    def _is_silent(self, now_s: float) -> bool:
        return self.last_message_s is None or now_s - self.last_message_s >= SILENT_S

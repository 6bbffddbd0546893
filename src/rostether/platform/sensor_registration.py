"""The description of a sensor, the request to register it by id, and the checks of its fields."""

from __future__ import annotations

import re
from typing import Any

from msgspec import Struct

from rostether.errors import ServiceCallError
from rostether.platform.sensor_state import MAX_STATE_TEXT_CHARACTERS, REPORTED

# Names and ids that fit in a line of the page.
MAX_TEXT_CHARACTERS = 100

# Shorter leases load the manager with renewals; with longer ones, a robot without power is listed too long.
_MIN_LEASE_S = 1.0
_MAX_LEASE_S = 3600.0

# No sensor publishes faster.
MAX_RATE_HZ = 1e6

# By field: the allowed texts, and an example.
_FORMS = {
    "id": (re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*)*", re.ASCII), "a name such as robot3/front"),
    "sensor_type": (re.compile(r"[A-Z][A-Z0-9_]*"), "a word such as ANALOG"),
    "message_type": (re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*", re.ASCII), "a type such as std_msgs/Float64"),
}

# The fields that have the same name in a sensor, a registration and their messages.
_SHARED_FIELDS = ("sensor_type", "message_type", "unit", "frame_id", "rate_hz", "lease_s")


def fields_of(described: object) -> dict[str, Any]:
    """Return the shared fields of a sensor, a registration or a message."""
    return {name: getattr(described, name) for name in _SHARED_FIELDS}


class SensorDescription(Struct, frozen=True):
    """Describes a sensor; `id` is the robot's name and the sensor's name, such as `robot3/front`."""

    id: str
    platform: str
    sensor_type: str
    message_type: str
    name: str = ""
    unit: str = ""
    frame_id: str = ""
    rate_hz: float = 0.0

    @property
    def topic(self) -> str:
        """The full name of its topic, as the manager assigns it."""
        return f"/sensors/{self.id}"


class Registration(SensorDescription, frozen=True, kw_only=True):
    """A request to register by id, or to renew the lease.

    `instance` identifies the process: while it holds the lease, other processes are refused.
    """

    instance: str
    lease_s: float = 0.0
    state: str = "ready"
    state_text: str = ""

    def check(self) -> None:
        """Raise ServiceCallError for a field that cannot be used."""
        for what, (pattern, example) in _FORMS.items():
            text = getattr(self, what)
            if not pattern.fullmatch(text) or len(text) > MAX_TEXT_CHARACTERS:
                raise ServiceCallError(f"{what} must be {example}, not {text!r:.100}")
        if not _MIN_LEASE_S <= self.lease_s <= _MAX_LEASE_S:
            raise ServiceCallError(
                f"lease_s must be {_MIN_LEASE_S:g} to {_MAX_LEASE_S:g}, not {self.lease_s:g}"
            )
        if not 0 <= self.rate_hz <= MAX_RATE_HZ:
            raise ServiceCallError(f"rate_hz must be 0 (unknown) to {MAX_RATE_HZ:g}, not {self.rate_hz:g}")
        if self.state not in REPORTED:
            raise ServiceCallError(f"state must be one of {', '.join(REPORTED)}, not {self.state!r:.100}")
        check_text("platform_name", self.platform)
        for what in ("instance", "name", "unit", "frame_id"):
            if text := getattr(self, what):
                check_text(what, text)
        if self.state_text:
            check_text("state_text", self.state_text, MAX_STATE_TEXT_CHARACTERS)


def check_text(what: str, text: str, limit: int = MAX_TEXT_CHARACTERS) -> None:
    """Raise ServiceCallError for a text that is empty, too long, or not printable."""
    if not text.strip() or len(text) > limit or not text.isprintable():
        raise ServiceCallError(f"{what} must be 1 to {limit} printable characters, not {text!r:.100}")

"""Faults as they happen, one text in one module: the fuzz targets must find each in 20 s of CPU time."""

from __future__ import annotations

from typing import NamedTuple


class Plant(NamedTuple):
    """A fault: `old`, which stands in the module once, becomes `new`; `target` must find it."""

    name: str
    target: str
    module: str
    old: str
    new: str


_ALL = (
    Plant(
        "frame-checksum-unchecked",
        "frame_decoder",
        "rostether.rosserial.frame_scan",
        "good = [payload] if (summer(payload) + buffer[end - 1]) & 0xFF == target else []",
        "good = [payload]",
    ),
    Plant(
        "frame-limit-off-by-one",
        "frame_decoder",
        "rostether.rosserial.frame_scan",
        "if length > self._most(topic_id) or length > self._max_payload_bytes:",
        "if length > self._most(topic_id) + 1:",
    ),
    Plant(
        "frame-resync-one-byte-too-far",
        "frame_decoder",
        "rostether.rosserial.frame_scan",
        "sums = RunningSums(buffer)\n                looks += total // LOOK_RUNNING_SUMS_BYTES\n"
        "            position = _find(buffer, _SYNC, position + 1)",
        "sums = RunningSums(buffer)\n                looks += total // LOOK_RUNNING_SUMS_BYTES\n"
        "            position = _find(buffer, _SYNC, position + 2)",
    ),
    Plant(
        "packet-trailing-byte",
        "packets",
        "rostether.rosserial.packets",
        "return self._position == len(self._payload)",
        "return self._position <= len(self._payload)",
    ),
    Plant(
        "packet-negative-buffer",
        "packets",
        "rostether.rosserial.packets",
        "if not 0 <= self.buffer_size <= MAX_BUFFER_BYTES:",
        "if not self.buffer_size <= MAX_BUFFER_BYTES:",
    ),
    Plant(
        "packet-short-time-raises",
        "device_link",
        "rostether.rosserial.packets",
        "if len(payload) != TIME_BYTES:\n        return None",
        "if not payload:\n        return None",
    ),
    Plant(
        "host-one-endpoint-too-many",
        "host_link",
        "rostether.rosserial.topic_table",
        "len(self._endpoints) >= self._max_endpoints",
        "len(self._endpoints) > self._max_endpoints",
    ),
    Plant(
        "host-sends-what-does-not-fit",
        "host_link",
        "rostether.rosserial.host_output",
        "if largest > limit:",
        "if largest > limit + 1:",
    ),
    Plant(
        "host-queue-unbounded",
        "host_link",
        "rostether.rosserial.host_output",
        "while self._waiting_bytes > MAX_WAITING_BYTES:",
        "while False:",
    ),
    Plant(
        "host-trusts-after-reset",
        "host_link",
        "rostether.rosserial.topic_table",
        "            endpoint.is_current = False\n",
        "            pass\n",
    ),
    Plant(
        "host-control-rate-unlimited",
        "host_link",
        "rostether.rosserial.control_rate",
        "admitted = min(count, int(self._room))",
        "admitted = count",
    ),
    Plant(
        "device-queue-unbounded",
        "device_link",
        "rostether.rosserial.device_link",
        "if self._state is not State.CONFIGURED or self._outgoing_bytes > MAX_WAITING_BYTES:",
        "if self._state is not State.CONFIGURED:",
    ),
    Plant(
        "device-input-buffer-ignored",
        "device_link",
        "rostether.rosserial.device_link",
        "            max_payload_bytes=self._config.input_buffer_bytes,\n",
        "",
    ),
    Plant(
        "session-question-ends-the-relay",
        "session",
        "rostether.bridge.parameter_relay",
        "except LocalProtocolError:",
        "except KeyError:",
    ),
    Plant(
        "session-call-ends-the-caller",
        "session",
        "rostether.bridge.service_client_endpoint",
        "except Exception as error:  # noqa: BLE001 - the board waits, and calls again",
        "except TypeError as error:",
    ),
)

PLANTS = {plant.name: plant for plant in _ALL}

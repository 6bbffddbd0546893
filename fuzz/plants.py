"""Typical faults, each one text in one module: the fuzz targets must find each in 20 s of CPU time."""

from __future__ import annotations

from typing import NamedTuple


class Plant(NamedTuple):
    """A fault: `old`, which occurs in the module once, becomes `new`; `target` must find it."""

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
        "good = [payload] if (sum_of(payload) + buffer[end - 1]) & 0xFF == target else []",
        "good = [payload]",
    ),
    Plant(
        "frame-limit-off-by-one",
        "frame_decoder",
        "rostether.rosserial.frame_scan",
        "if length > self._max_length(topic_id) or length > self._max_payload_bytes:",
        "if length > self._max_length(topic_id) + 1:",
    ),
    Plant(
        "frame-resync-one-byte-too-far",
        "frame_decoder",
        "rostether.rosserial.frame_scan",
        "found = self._buffer.find(wanted, position + 1)",
        "found = self._buffer.find(wanted, position + 2)",
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
        "        self.send_limits.clear()\n",
        "        pass\n",
    ),
    Plant(
        "host-control-rate-unlimited",
        "host_link",
        "rostether.mechanisms.rate_limits",
        "admitted = min(count, int(self.room(now_s)))",
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
        "rostether.bridge.endpoint.service_client",
        "except Exception as error:  # noqa: BLE001 - the board waits, and calls again",
        "except TypeError as error:",
    ),
    Plant(
        "tcpros-header-limit-off-by-one",
        "tcpros",
        "rostether.tcpros.header",
        "if length > self._max_header_bytes:",
        "if length > self._max_header_bytes + 1:",
    ),
    Plant(
        "tcpros-run-of-messages-unbounded",
        "tcpros",
        "rostether.tcpros.message_framing",
        "        if length > self._max_message_bytes:\n            raise self._too_long(length)\n"
        "        stride",
        "        stride",
    ),
    Plant(
        "tcpros-fields-unbounded",
        "tcpros",
        "rostether.tcpros.header",
        "if count > MAX_FIELDS:",
        "if False:",
    ),
    Plant(
        "xmlrpc-values-unbounded",
        "xmlrpc",
        "rostether.xmlrpc.document_reader",
        "if self._count > MAX_VALUES:",
        "if False:",
    ),
    Plant(
        "xmlrpc-integer-beyond-32-bits",
        "xmlrpc",
        "rostether.xmlrpc.document_reader",
        "if not MIN_INT <= value <= MAX_INT:",
        "if not MIN_INT <= value <= MAX_INT + 1:",
    ),
    Plant(
        "http-chunks-unbounded",
        "http",
        "rostether.xmlrpc.http_message",
        "                if len(self._body) > self._max_body_bytes:\n                    self._refuse(",
        "                if False:\n                    self._refuse(",
    ),
    Plant(
        "http-origin-in-capitals-admitted",
        "http",
        "rostether.xmlrpc.http_message",
        'elif b"origin" in headers:',
        'elif b"Origin" in headers:',
    ),
    Plant(
        "definition-field-too-many",
        "definitions",
        "rostether.msgdef.parse_msg",
        "if len(fields) == MAX_FIELDS:",
        "if len(fields) == MAX_FIELDS + 1:",
    ),
    Plant(
        "definition-array-unbounded",
        "definitions",
        "rostether.msgdef.parse_msg",
        "if length > MAX_ARRAY_LENGTH:",
        "if length > 10 * MAX_ARRAY_LENGTH:",
    ),
    Plant(
        "cdr-trailing-bytes",
        "cdr",
        "rostether.serde.layout_source",
        'f"        return {body.position()} == len(b)"',
        'f"        return {body.position()} <= len(b)"',
    ),
    Plant(
        "cdr-string-without-its-nul",
        "cdr",
        "rostether.serde.cdr.converting_body",
        'f"pack({count} + 1)"',
        'f"pack({count})"',
    ),
    Plant(
        "yaml-list-of-wrong-length-raises",
        "yaml_form",
        "rostether.serde.yaml_form",
        "if len(value) != len(nodes):",
        "if len(value) > len(nodes):",
    ),
    Plant(
        "toml-depth-unbounded",
        "devices_toml",
        "rostether.ports.devices_toml",
        'table.names_to_numbers("queue_depths", 1, MAX_QUEUE_DEPTH)',
        'table.names_to_numbers("queue_depths", 1, 1 << 40)',
    ),
    Plant(
        "toml-odd-address-raises",
        "devices_toml",
        "rostether.ports.devices_toml",
        "    except ValueError:\n        return None",
        "    except TypeError:\n        return None",
    ),
    Plant(
        "toml-long-number-raises",
        "devices_toml",
        "rostether.mechanisms.toml_text",
        "except ValueError:",
        "except KeyError:",
    ),
    Plant(
        "address-port-off-by-one",
        "address",
        "rostether.transports.address_parser",
        "int(port_text) <= MAX_PORT",
        "int(port_text) <= MAX_PORT + 1",
    ),
    Plant(
        "address-long-number-raises",
        "address",
        "rostether.transports.address_advice",
        "return text.isascii() and text.isdigit() and len(text) <= 20",
        "return text.isascii() and text.isdigit()",
    ),
    Plant(
        "psk-compares-a-beginning",
        "psk_hello",
        "rostether.transports.psk_hello",
        'if hmac.compare_digest(proof, _proof(key, "connector", self._nonce, theirs)):',
        'if hmac.compare_digest(proof[:8], _proof(key, "connector", self._nonce, theirs)[:8]):',
    ),
    Plant(
        "psk-line-unbounded",
        "psk_hello",
        "rostether.transports.psk_hello",
        "if len(line) > MAX_LINE_BYTES:",
        "if end and len(line) > MAX_LINE_BYTES:",
    ),
    Plant(
        "xbee-frame-limit-off-by-one",
        "xbee",
        "rostether.transports.xbee.frame",
        "if length > MAX_FRAME_BYTES:",
        "if length > MAX_FRAME_BYTES + 1:",
    ),
    Plant(
        "xbee-short-answer-raises",
        "xbee",
        "rostether.transports.xbee.packets",
        "case 0x88 if len(data) >= 5:",
        "case 0x88:",
    ),
    Plant(
        "recording-left-open",
        "recordings",
        "rostether.recording.regular_file",
        "weakref.finalize(self, os.close, self._descriptor)",
        "bool",
    ),
    Plant(
        "recording-chunk-unbounded",
        "recordings",
        "rostether.recording.compression",
        "elif size_bytes > MAX_CHUNK_BYTES:",
        "elif size_bytes > 64 * MAX_CHUNK_BYTES:",
    ),
    Plant(
        "rosbridge-topics-unbounded",
        "rosbridge",
        "rostether.gateways.rosbridge.client_topics",
        "if len(self._publications) >= MAX_PUBLICATIONS and topic not in self._publications:",
        "if False:",
    ),
    Plant(
        "rosbridge-fragment-number-off-by-one",
        "rosbridge",
        "rostether.gateways.rosbridge.fragments",
        "not 0 <= number < total <= MAX_FRAGMENTS",
        "not 0 <= number <= total <= MAX_FRAGMENTS",
    ),
    Plant(
        "foxglove-channel-too-many",
        "foxglove",
        "rostether.gateways.foxglove.client",
        "len(self._topics) >= self._context.limits.client_channels",
        "len(self._topics) > self._context.limits.client_channels",
    ),
    Plant(
        "foxglove-short-message-raises",
        "foxglove",
        "rostether.gateways.foxglove.client_messages",
        "if opcode == _MESSAGE_DATA and len(data) >= _CHANNEL_ID.size:",
        "if opcode == _MESSAGE_DATA:",
    ),
)

PLANTS = {plant.name: plant for plant in _ALL}

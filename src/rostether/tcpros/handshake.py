"""The TCPROS handshake: the header fields that each side sends first, and their check.

The side that connects sends its request. The other side answers with its own fields, or with one field
`error` and the end of the connection. The first header decides the purpose of a connection:

    field present            purpose          answered, then
    topic                    SUBSCRIBE        messages flow to the peer until one side closes
    service, probe=1         PROBE            the peer closes; it only checked that the service exists
    service, persistent=1    CALL_PERSISTENT  requests and answers alternate until one side closes
    service                  CALL_ONCE        one request, one answer, end

An md5sum or type of `*` agrees with every other. The names of types are compared only to explain why
md5sums differ, as in rospy and roscpp.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from rostether.errors import GraphError, RemoteProtocolError, TypeMismatchError
from rostether.mechanisms.text import escape_line
from rostether.msgdef.interface import ANY_MD5SUM, ANY_TYPE, MessageType, ServiceType, agree

# A peer's text becomes part of a line in the log: longer than the texts of rospy and roscpp.
MAX_SHOWN_CHARS = 500


class Purpose(Enum):
    """The request of the connected peer."""

    SUBSCRIBE = "subscribe"
    PROBE = "probe"
    CALL_PERSISTENT = "call, persistent"
    CALL_ONCE = "call once"


_PURPOSES: tuple[tuple[str, str, Purpose], ...] = (
    # required field, another field that must be true
    ("topic", "", Purpose.SUBSCRIBE),
    ("service", "probe", Purpose.PROBE),
    ("service", "persistent", Purpose.CALL_PERSISTENT),
    ("service", "", Purpose.CALL_ONCE),
)


def is_true(fields: Mapping[str, str], key: str) -> bool:
    """Return whether a flag of a header is set."""
    return fields.get(key, "").strip().lower() in ("1", "true")


def purpose_of(fields: Mapping[str, str]) -> Purpose:
    """Classify an incoming connection by its header. Raises RemoteProtocolError."""
    for field, flag, purpose in _PURPOSES:
        if field in fields and (not flag or is_true(fields, flag)):
            if "md5sum" not in fields:
                raise RemoteProtocolError("Missing required 'md5sum' field")
            return purpose
    raise RemoteProtocolError("no topic or service name detected")


def subscriber_fields(
    topic: str, message_type: MessageType, *, caller_id: str, tcp_nodelay: bool
) -> dict[str, str]:
    """Return the header of a subscriber."""
    return _topic_fields(topic, message_type, caller_id) | {"tcp_nodelay": "1" if tcp_nodelay else "0"}


def publisher_fields(topic: str, message_type: MessageType, *, caller_id: str, latch: bool) -> dict[str, str]:
    """Return a publisher's answer."""
    return _topic_fields(topic, message_type, caller_id) | {"latching": "1" if latch else "0"}


def client_fields(
    service: str, service_type: ServiceType, *, caller_id: str, persistent: bool
) -> dict[str, str]:
    """Return the header of a service client."""
    fields = {
        "service": service,
        "type": service_type.name,
        "md5sum": service_type.md5sum,
        "callerid": caller_id,
    }
    return fields | {"persistent": "1"} if persistent else fields


def probe_fields(service: str, *, caller_id: str) -> dict[str, str]:
    """Return the header of a probe, which only asks for a service's type."""
    return {"service": service, "md5sum": ANY_MD5SUM, "callerid": caller_id, "probe": "1"}


def server_fields(service: str, service_type: ServiceType, *, caller_id: str) -> dict[str, str]:
    """Return a service server's answer."""
    return {
        "service": service,
        "type": service_type.name,
        "md5sum": service_type.md5sum,
        "request_type": service_type.request.name,
        "response_type": service_type.response.name,
        "callerid": caller_id,
    }


def check_subscriber(fields: Mapping[str, str], topic: str, message_type: MessageType) -> None:
    """Check a subscriber's header for our publication. Raises TypeMismatchError with the text to send."""
    if agree(fields["md5sum"], message_type.md5sum):
        return
    wanted = fields.get("type", message_type.name)
    if not agree(wanted, message_type.name):
        raise TypeMismatchError(f"topic types do not match: [{_short(wanted)}] vs. [{message_type.name}]")
    raise TypeMismatchError(
        f"Client [{_shown(fields, 'callerid')}] wants topic [{topic}] to have datatype/md5sum "
        f"[{_short(wanted)}/{_shown(fields, 'md5sum')}], but our version has "
        f"[{message_type.name}/{message_type.md5sum}]. Dropping connection."
    )


def check_publisher(fields: Mapping[str, str], topic: str, message_type: MessageType) -> None:
    """Check a publisher's answer for our subscription.

    Raises TypeMismatchError, GraphError with the publisher's text, RemoteProtocolError.
    """
    _check_answer(fields)
    if not agree(fields["md5sum"], message_type.md5sum):
        raise TypeMismatchError(
            f"{topic} is published as {_shown(fields, 'type')} (md5sum {_shown(fields, 'md5sum')}), "
            f"not as {message_type.name} (md5sum {message_type.md5sum}); make both ends use one definition"
        )


def check_client(fields: Mapping[str, str], service_type: ServiceType) -> None:
    """Check a client's header against our service. Raises TypeMismatchError with the text to send."""
    if not agree(fields["md5sum"], service_type.md5sum):
        raise TypeMismatchError(
            f"request from [{_shown(fields, 'callerid')}]: md5sums do not match: "
            f"[{_shown(fields, 'md5sum')}] vs. [{service_type.md5sum}]"
        )


def check_server(fields: Mapping[str, str], service: str, service_type: ServiceType) -> None:
    """Check a server's answer against the type we call.

    Raises TypeMismatchError, GraphError with the server's text, RemoteProtocolError.
    """
    try:
        _check_answer(fields)
    except TypeMismatchError as error:
        raise TypeMismatchError(
            f"service {service} has another type or definition than {service_type.name} ({error}); "
            f"`rostether service type {service}` shows its type"
        ) from None
    # roscpp's servers answer with the md5sum only, rospy's with all fields.
    if not agree(fields["md5sum"], service_type.md5sum):
        raise TypeMismatchError(
            f"service {service} has type {_shown(fields, 'type')} (md5sum {_shown(fields, 'md5sum')}), "
            f"not {service_type.name} (md5sum {service_type.md5sum}); make both ends use one definition"
        )


def type_of(fields: Mapping[str, str]) -> MessageType:
    """Return the type in a publisher's header; a missing name or md5sum is `*`."""
    return MessageType(
        fields.get("type", ANY_TYPE), fields.get("md5sum", ANY_MD5SUM), fields.get("message_definition", "")
    )


def _topic_fields(topic: str, message_type: MessageType, caller_id: str) -> dict[str, str]:
    return {
        "topic": topic,
        "type": message_type.name,
        "md5sum": message_type.md5sum,
        "message_definition": message_type.definition,
        "callerid": caller_id,
    }


def _check_answer(fields: Mapping[str, str]) -> None:
    if "error" in fields:
        text = fields["error"]
        # For another type, the texts of rospy and roscpp have "md5sum", or in rospy "topic types".
        kind = TypeMismatchError if "md5sum" in text or "types do not match" in text else GraphError
        raise kind(_short(text))
    if "md5sum" not in fields:
        raise RemoteProtocolError("the connection header lacks the field md5sum")


def _shown(fields: Mapping[str, str], name: str) -> str:
    return _short(fields.get(name, "?"))


def _short(text: str) -> str:
    return escape_line(text, MAX_SHOWN_CHARS)

"""A board's permissions in devices.toml, checked before anything is opened in the graph."""

from __future__ import annotations

from rostether.errors import AccessDeniedError
from rostether.ports.settings import Access
from rostether.rosserial.events import ServiceRole, TopicRole

_WORDS = {
    "publish": "publish",
    "subscribe": "subscribe to",
    "serve": "serve",
    "call": "call",
    "parameters": "read",
}
_KINDS = {
    TopicRole.PUBLISHER: "publish",
    TopicRole.SUBSCRIBER: "subscribe",
    ServiceRole.SERVER: "serve",
    ServiceRole.CLIENT: "call",
}


def check_endpoint(access: Access, role: TopicRole | ServiceRole, name: str) -> None:
    """Check that a board may have an endpoint under a resolved name. Raises AccessDeniedError."""
    _check(access, _KINDS[role], name)


def check_parameter(access: Access, name: str) -> None:
    """Check that a board may read a parameter with this resolved name. Raises AccessDeniedError."""
    _check(access, "parameters", name)


def _check(access: Access, kind: str, name: str) -> None:
    reason = getattr(access, kind).refusal(name)
    if reason is not None:
        raise AccessDeniedError(
            f"this board may not {_WORDS[kind]} {name}: access.{kind}.{reason}; change devices.toml to allow"
            " it"
        )

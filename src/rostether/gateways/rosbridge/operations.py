"""The operations of the rosbridge protocol, each with its handler."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, TypeAlias

from rostether.gateways.rosbridge.status import StatusLevel

if TYPE_CHECKING:
    from rostether.gateways.rosbridge.request import Request
    from rostether.gateways.rosbridge.session import Session

Operation: TypeAlias = "Callable[[Session, Request], Awaitable[object] | None]"


async def _advertise_service(session: Session, request: Request) -> None:
    warning = await session.services.advertise(request)
    if warning:
        session.status(StatusLevel.WARNING, warning, request.id)


def _set_level(session: Session, request: Request) -> None:
    session.level = StatusLevel.read(request.fields.get("level"))


def _ignore(session: Session, request: Request) -> None:
    """Ignore a client's status, and a repeated authentication."""


OPERATIONS: dict[str, Operation] = {
    "advertise": lambda session, request: session.topics.advertise(request),
    "unadvertise": lambda session, request: session.topics.unadvertise(request),
    "publish": lambda session, request: session.topics.publish(request),
    "subscribe": lambda session, request: session.topics.subscribe(request),
    "unsubscribe": lambda session, request: session.topics.unsubscribe(request),
    "call_service": lambda session, request: session.services.call(request),
    "advertise_service": _advertise_service,
    "unadvertise_service": lambda session, request: session.services.unadvertise(request),
    "service_response": lambda session, request: session.services.answer(request),
    "send_action_goal": lambda session, request: session.actions.send_goal(request),
    "cancel_action_goal": lambda session, request: session.actions.cancel_goal(request),
    "advertise_action": lambda session, request: session.actions.advertise(request),
    "unadvertise_action": lambda session, request: session.actions.unadvertise(request),
    "action_feedback": lambda session, request: session.actions.feedback(request),
    "action_result": lambda session, request: session.actions.result(request),
    "fragment": lambda session, request: session.handle_fragment(request),
    "png": lambda session, request: session.handle_png(request),
    "set_level": _set_level,
    "status": _ignore,
    "auth": _ignore,
}

"""Services whose halves were described as messages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rostether.msgdef.ros2.parse import REQUEST_SUFFIX, RESPONSE_SUFFIX
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service


def joined_services(messages: Mapping[str, Ros2Message]) -> Iterator[Ros2Service]:
    """Yield the services of which both halves are among the messages, which are given by full name."""
    for name, request in messages.items():
        service = name.removesuffix(REQUEST_SUFFIX)
        response = messages.get(service + RESPONSE_SUFFIX)
        if service != name and request.kind in ("srv", "action") and response is not None:
            short_name = request.name.removesuffix(REQUEST_SUFFIX)
            yield Ros2Service(request.package, short_name, request, response, request.kind)

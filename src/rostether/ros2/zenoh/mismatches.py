"""Explains why two endpoints of one topic do not connect: zenoh itself reports nothing."""

from __future__ import annotations

from collections.abc import Sequence

from rostether.graph.ports import Level, Report
from rostether.ros2.endpoint_info import EndpointKind, different_type_text
from rostether.ros2.naming import dds_name, type_of_dds_name
from rostether.ros2.types.type_support import MessageSupport, ServiceSupport
from rostether.ros2.zenoh.tokens import Token, TokenKind


def is_of_type(token: Token, support: MessageSupport | ServiceSupport) -> bool:
    """Return whether an endpoint has a type, with the same definition."""
    return token.type == dds_name(support.name) and token.type_hash == support.type_hash


class Mismatches:
    """Reports each endpoint of a topic with a different type once."""

    def __init__(self, topic: str, support: MessageSupport, report: Report) -> None:
        self._topic = topic
        self._support = support
        self._report = report
        self._reported: set[Token] = set()

    def report(self, tokens: Sequence[Token]) -> None:
        """Report the mismatches among the current endpoints; forget endpoints that have ended."""
        wrong = {token for token in tokens if not is_of_type(token, self._support)}
        for token in wrong - self._reported:
            self._report(Level.WARN, self._explain(token))
        self._reported = wrong

    def _explain(self, token: Token) -> str:
        is_publisher = token.kind is TokenKind.PUBLISHER
        if token.type != dds_name(self._support.name):
            kind = EndpointKind.PUBLISHER if is_publisher else EndpointKind.SUBSCRIPTION
            other = type_of_dds_name(token.type) or token.type
            return different_type_text(token.node_name, kind, self._topic, other, self._support.name)
        verb = "publishes" if is_publisher else "subscribes to"
        return (
            f"{token.node_name:.200} {verb} {self._topic} with another definition of {self._support.name} "
            f"({token.type_hash:.80}, not {self._support.type_hash}), so they do not connect; set ROS_DISTRO "
            "to its distribution, or give its definition with --msg-path"
        )

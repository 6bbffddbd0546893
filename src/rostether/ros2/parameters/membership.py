"""What parameters need of the graph below them: half of the graph port, so that any graph can carry them."""

from __future__ import annotations

from typing import Protocol

from rostether.graph.ports import OnMessages, Publisher, ServiceHandler, ServiceServer, Snapshot, Subscriber
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.rostime import Time


class Membership(Protocol):
    """One node's membership of a ROS 2 graph; a whole `graph.ports.Graph` is one."""

    @property
    def node_name(self) -> str:
        """The node's fully qualified name."""

    async def advertise(self, topic: str, message_type: MessageType) -> Publisher:
        """Advertise a topic."""

    async def subscribe(self, topic: str, message_type: MessageType, on_messages: OnMessages) -> Subscriber:
        """Subscribe."""

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ServiceServer:
        """Offer a service."""

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service."""

    def now(self) -> Time:
        """Return ROS time."""

    async def snapshot(self) -> Snapshot:
        """Return the graph: its nodes and services."""

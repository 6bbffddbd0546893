"""The topics of one client: those that it publishes, and those that it subscribes to."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import RemoteProtocolError, TypeMismatchError, UnknownNameError
from rostether.gateways.rosbridge.client_publication import ClientPublication
from rostether.gateways.rosbridge.client_subscription import ClientSubscription, Delivery
from rostether.gateways.rosbridge.outbox import Outbox
from rostether.gateways.rosbridge.request import Request
from rostether.gateways.rosbridge.rosbridge_context import RosbridgeContext
from rostether.gateways.rosbridge.settings import MAX_PUBLICATIONS, MAX_SUBSCRIPTIONS, check_allowed
from rostether.gateways.type_names import short_type
from rostether.msgdef.interface import ANY_TYPE, MessageType


class ClientTopics:
    """The topics that one client publishes or subscribes to. Methods raise RostetherError."""

    def __init__(
        self,
        context: RosbridgeContext,
        outbox: Outbox[ClientSubscription],
        report_error: Callable[[str], None],
    ) -> None:
        self._context = context
        self._outbox = outbox
        self._report_error = report_error
        self._publications: dict[str, ClientPublication] = {}
        self._subscriptions: dict[str, ClientSubscription] = {}

    async def advertise(self, request: Request) -> None:
        """Announce that the client publishes a topic."""
        topic, type_name = request.word("topic"), request.word("type")
        message_type = self._context.store.registry.message_type(short_type(type_name))
        known = self._publications.get(topic)
        latch = request.flag("latch")
        if known is None or known.type != message_type or known.is_latching < latch:
            known = await self._advertise(topic, message_type, latch=latch)
        known.add_id(request.id)

    async def unadvertise(self, request: Request) -> None:
        """Remove the advertisement with the request's id; without an id, all of the client's for the topic.

        After the last one, subscribers stay connected for a while, in case it is advertised again.
        """
        topic = request.word("topic")
        publication = self._publications.get(topic)
        if publication is None:
            raise UnknownNameError(f"unadvertise: this client does not advertise {topic}; check the name")
        if not publication.remove_id(request.id):
            del self._publications[topic]
            self._context.linger(publication)

    async def publish(self, request: Request) -> None:
        """Publish a message; a topic that was not advertised must exist."""
        topic = request.word("topic")
        publication = self._publications.get(topic)
        if publication is None:
            message_type = await self._type_of(topic)
            publication = await self._advertise(topic, message_type, latch=request.flag("latch"))
        message = request.fields.get("msg", {})
        payload = await self._context.forms.payload(publication.type.name, message, request)
        await publication.publish(payload)

    async def subscribe(self, request: Request) -> None:
        """Subscribe to a topic, which need not exist yet."""
        topic = request.word("topic")
        delivery = Delivery.read(request)
        type_name = request.optional_word("type")
        known = self._subscriptions.get(topic)
        if known is not None:
            known.add_request(request.id, delivery, type_name)
            return
        self._check_allowed(topic)
        if len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
            raise RemoteProtocolError(
                f"subscribe: at most {MAX_SUBSCRIPTIONS} topics are allowed; unsubscribe some"
            )
        subscription = ClientSubscription(topic, self._outbox, self._report_error)
        subscription.add_request(request.id, delivery, type_name)
        self._subscriptions[topic] = subscription
        try:
            subscription.share = await self._context.shared.subscribe(topic, subscription.enqueue)
        except BaseException:
            del self._subscriptions[topic]
            await subscription.close()
            raise

    async def unsubscribe(self, request: Request) -> None:
        """Remove the subscription with the request's id; without an id, all of the client's to the topic."""
        topic = request.word("topic")
        subscription = self._subscriptions.get(topic)
        if subscription is None:
            raise UnknownNameError(f"unsubscribe: this client is not subscribed to {topic}; check the name")
        if not subscription.remove_request(request.id):
            del self._subscriptions[topic]
            await subscription.close()

    async def close(self) -> None:
        """End the subscriptions, and let the publications linger."""
        for publication in self._publications.values():
            self._context.linger(publication)
        self._publications.clear()
        subscriptions = list(self._subscriptions.values())
        self._subscriptions.clear()
        await asyncio.gather(*(each.close() for each in subscriptions))

    async def _advertise(self, topic: str, message_type: MessageType, *, latch: bool) -> ClientPublication:
        self._check_allowed(topic)
        if len(self._publications) >= MAX_PUBLICATIONS and topic not in self._publications:
            raise RemoteProtocolError(
                f"advertise: at most {MAX_PUBLICATIONS} topics are allowed; unadvertise some"
            )
        old = self._publications.pop(topic, None)
        if old is not None:
            await old.close()
        graph = self._context.graph
        await self._check_type(topic, message_type)
        try:
            publisher = await graph.advertise(topic, message_type, latch=latch)
        except TypeMismatchError:
            # A reloaded page may choose another type.
            if not await self._context.end_lingering(graph.resolve(topic)):
                raise
            publisher = await graph.advertise(topic, message_type, latch=latch)
        publication = self._publications[topic] = ClientPublication(graph, publisher, is_latching=latch)
        return publication

    async def _type_of(self, topic: str) -> MessageType:
        name = self._context.graph.resolve(topic)
        known = (await self._context.graph.snapshot()).topics.get(name)
        if known is None or known.type == ANY_TYPE:
            raise UnknownNameError(f"publish: {topic} has no type yet; advertise it first")
        return self._context.store.registry.message_type(short_type(known.type))

    async def _check_type(self, topic: str, message_type: MessageType) -> None:
        """Raise TypeMismatchError for a type that differs from the type of other nodes.

        These nodes would not receive the messages, and a ROS 1 master would report the new type to all nodes.
        """
        graph = self._context.graph
        known = (await graph.snapshot()).topics.get(graph.resolve(topic))
        if (
            known is None
            or known.type == ANY_TYPE
            or not {*known.publishers, *known.subscribers} - {graph.node_name}
        ):
            return
        # Several types on one ROS 2 topic are separated by spaces.
        if short_type(message_type.name) not in map(short_type, known.type.split()):
            raise TypeMismatchError(f"advertise: {topic} has the type {known.type}; use it")

    def _check_allowed(self, topic: str) -> None:
        name = self._context.graph.resolve(topic)
        check_allowed(name, self._context.settings.topics_glob, "topics_glob")

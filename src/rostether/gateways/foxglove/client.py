"""One client of a gateway: its requests and the messages sent to it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from rostether.errors import InvalidNameError, RemoteProtocolError
from rostether.gateways.foxglove import client_messages as requests
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.client_parameters import ClientParameters
from rostether.gateways.foxglove.client_sender import ClientSender
from rostether.gateways.foxglove.client_topics import ClientTopic
from rostether.gateways.foxglove.client_work import ClientWork
from rostether.gateways.foxglove.driven_topic import DrivenTopic
from rostether.gateways.foxglove.foxglove_context import FoxgloveContext
from rostether.gateways.foxglove.recordings import ClientRecordings
from rostether.gateways.foxglove.server_messages import Channel, StatusLevel
from rostether.gateways.foxglove.subscription import Subscription
from rostether.gateways.websocket.access_rules import Rights
from rostether.gateways.websocket.connection import Connection

# The limit of statuses about a client's errors; more statuses would only flood the client.
MAX_REPORTED_ERRORS = 100

# The refusal for a client that may only view.
_VIEW_ONLY = "this connection may only view; open the page with the full token to publish, call and set"


class Client:
    """The user of a client's connection; `on_closed` is called when the client has left."""

    def __init__(
        self,
        context: FoxgloveContext,
        connection: Connection,
        on_closed: Callable[[Client], None],
        rights: Rights,
    ) -> None:
        self.sender = sender = ClientSender(connection, context.limits)
        self._rights = rights
        self.wants_connection_graph = False
        self._context = context
        self._on_closed = on_closed
        self._subscriptions: dict[int, Subscription] = {}
        self._by_channel: dict[int, Subscription] = {}
        self._topics: dict[int, ClientTopic | DrivenTopic] = {}
        self._work = ClientWork()
        self._parameters = ClientParameters(context, self._work, sender.send, self.report_error)
        self._recordings = ClientRecordings(
            context.recordings, self._work, sender.send, self.report_error, context.run
        )
        self._fetching = asyncio.Lock()
        self._error_count = 0
        self._waiting_publishers = 0
        self._handlers: dict[type, Callable[[Any], None]] = {
            requests.Subscribe: self._subscribe,
            requests.Unsubscribe: self._unsubscribe,
            requests.Advertise: self._advertise,
            requests.Unadvertise: self._unadvertise,
            requests.MessageData: self._publish,
            requests.ServiceRequest: self._call,
            requests.SubscribeConnectionGraph: self._watch_graph,
            requests.UnsubscribeConnectionGraph: self._unwatch_graph,
            requests.FetchAsset: self._fetch,
            requests.AskTime: self._send_time,
            **self._parameters.handlers,
            **self._recordings.handlers,
        }

    # Events of the connection.

    def received(self, message: str | bytes) -> None:
        """Handle a message."""
        try:
            if isinstance(message, str):
                request = requests.parse_text(message)
            else:
                request = requests.parse_binary(message)
        except RemoteProtocolError as error:
            self.report_error(str(error))
            return
        if request.capability and request.capability not in self._context.settings.capabilities:
            self.report_error(
                f"this gateway does not offer {request.capability}; add it to its ~capabilities"
            )
            return
        if self._rights is Rights.VIEW and isinstance(request, requests.Action):
            self._refuse(request)
            return
        self._handlers[type(request)](request)

    def paused(self) -> None:
        """Keep messages of topics waiting."""
        self.sender.pause()

    def resumed(self) -> None:
        """Send the waiting messages."""
        self.sender.resume()

    def closed(self) -> None:
        """End everything that belongs to the client."""
        self.sender.end()
        self._on_closed(self)
        self._recordings.close()
        self._work.cancel()
        for subscription in self._subscriptions.values():
            self._context.run(subscription.close())
        for topic in self._topics.values():
            self._context.run(topic.close())
        self._subscriptions.clear()
        self._by_channel.clear()
        self._topics.clear()
        self._parameters.close()

    # Calls from the gateway.

    def report_error(self, text: str) -> None:
        """Report an error to the client, up to a limit."""
        self._error_count += 1
        if self._error_count <= MAX_REPORTED_ERRORS:
            self.sender.send(replies.status(StatusLevel.ERROR, text))

    def channel_ended(self, channel: Channel) -> None:
        """End the subscription to a channel that has ended."""
        if subscription := self._by_channel.pop(channel.id, None):
            del self._subscriptions[subscription.id]
            self._context.run(subscription.close())

    # Requests.

    def _subscribe(self, request: requests.Subscribe) -> None:
        for given in request.subscriptions:
            subscription_id, channel_id = given.id, given.channel_id
            channel = self._context.channels.by_id.get(channel_id)
            if channel is None:
                # The client may not know yet that the channel has ended.
                self.report_error(f"there is no channel {channel_id}")
            elif subscription_id in self._subscriptions or channel_id in self._by_channel:
                self.report_error(
                    f"channel {channel_id} is already subscribed, or subscription {subscription_id} already "
                    "exists; unsubscribe first"
                )
            elif len(self._subscriptions) >= self._context.limits.subscriptions:
                limit = self._context.limits.subscriptions
                self.report_error(f"a client may have at most {limit} subscriptions; unsubscribe some")
            else:
                self._subscriptions[subscription_id] = self._by_channel[channel_id] = Subscription(
                    subscription_id, channel, self._context, self.sender, self.report_error
                )

    def _unsubscribe(self, request: requests.Unsubscribe) -> None:
        for subscription_id in request.subscription_ids:
            # The subscription may have ended with its channel.
            if subscription := self._subscriptions.pop(subscription_id, None):
                del self._by_channel[subscription.channel.id]
                self._context.run(subscription.close())

    def _advertise(self, request: requests.Advertise) -> None:
        for channel in request.channels:
            if channel.id in self._topics:
                self.report_error(f"channel {channel.id} is already advertised; choose another id")
            elif len(self._topics) >= self._context.limits.client_channels:
                limit = self._context.limits.client_channels
                self.report_error(f"a client may publish at most {limit} topics; unadvertise some")
            elif not channel.topic.strip("/"):
                self.report_error(f"channel {channel.id} has no topic; give its name")
            elif not self._may_publish(channel.topic):
                self.report_error(
                    f"clients may not publish {channel.topic[:200]}; add it to the gateway's "
                    "~client_topic_whitelist"
                )
            else:
                self._topics[channel.id] = self._topic(channel)

    def _topic(self, channel: requests.ClientChannel) -> ClientTopic | DrivenTopic:
        context = self._context
        if channel.driver is None or context.teleop is None:
            return ClientTopic(channel, context.graph, context.store, self.report_error)
        return DrivenTopic(channel, context, context.teleop, self.sender, self.report_error)

    def _may_publish(self, topic: str) -> bool:
        try:
            return self._context.settings.client_topics.includes(self._context.graph.resolve(topic))
        except InvalidNameError:
            # The graph reports the error.
            return True

    def _unadvertise(self, request: requests.Unadvertise) -> None:
        for channel_id in request.channel_ids:
            if topic := self._topics.pop(channel_id, None):
                self._context.run(topic.close())
            else:
                self.report_error(f"channel {channel_id} is not advertised; advertise it first")

    def _publish(self, message: requests.MessageData) -> None:
        topic = self._topics.get(message.channel_id)
        if topic is None:
            self.report_error(f"channel {message.channel_id} is not advertised; advertise it first")
        elif (room := topic.publish(message.payload)) is not None:
            self._work.start(self._wait_for(room))

    async def _wait_for(self, room: Awaitable[object]) -> None:
        self._waiting_publishers += 1
        self.sender.connection.pause_reading()
        try:
            await room
        finally:
            self._waiting_publishers -= 1
            if not self._waiting_publishers:
                self.sender.connection.resume_reading()

    def _call(self, request: requests.ServiceRequest) -> None:
        def fail(text: str) -> None:
            self.sender.send(replies.service_failure(request.service_id, request.call_id, text))

        service = self._context.services.by_id.get(request.service_id)
        if service is None:
            fail(f"there is no service {request.service_id}; its server may have just ended")
            return

        async def call() -> None:
            answer = await self._context.services.call(
                service, request.encoding, request.payload, self._context.limits.call_timeout_s
            )
            await self.sender.send_large(
                replies.service_response(request.service_id, request.call_id, request.encoding, answer)
            )

        self._work.ask(call, fail, self._context.limits.calls)

    def _watch_graph(self, _: requests.SubscribeConnectionGraph) -> None:
        if not self.wants_connection_graph:
            self.wants_connection_graph = True
            self.sender.send(replies.connection_graph_update(self._context.connections.whole()))

    def _unwatch_graph(self, _: requests.UnsubscribeConnectionGraph) -> None:
        self.wants_connection_graph = False

    def _send_time(self, request: requests.AskTime) -> None:
        self.sender.send(replies.time_answer(request.id, self._context.clock.now_ns()))

    def _fetch(self, request: requests.FetchAsset) -> None:
        async def fetch() -> None:
            # One at a time, because each may be large: the client receives it before the next file is read.
            head = replies.asset_head(request.request_id)
            async with self._fetching, self._context.assets.reading(request.uri, head) as message:
                await self.sender.send_large(message)

        self._work.ask(
            fetch,
            lambda text: self.sender.send(replies.asset_failure(request.request_id, text)),
            self._context.limits.assets,
            "assets",
        )

    # Internal methods.

    def _refuse(self, request: object) -> None:
        if isinstance(request, requests.ServiceRequest):
            self.sender.send(replies.service_failure(request.service_id, request.call_id, _VIEW_ONLY))
        else:
            self.report_error(_VIEW_ONLY)

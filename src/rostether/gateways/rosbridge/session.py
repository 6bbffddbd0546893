"""One client: handles its requests in order, and sends messages as fast as it reads them."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable
from itertools import count
from typing import TYPE_CHECKING, Any

from rostether.errors import RemoteProtocolError, RostetherError
from rostether.gateways.client_json import show
from rostether.gateways.rosbridge.client_actions import ClientActions
from rostether.gateways.rosbridge.client_services import ClientServices
from rostether.gateways.rosbridge.client_subscription import ClientSubscription, Compression, Delivery
from rostether.gateways.rosbridge.client_topics import ClientTopics
from rostether.gateways.rosbridge.fragments import Defragmenter, split_fragments
from rostether.gateways.rosbridge.outbox import Due, Frame, Outbox
from rostether.gateways.rosbridge.png_packing import pack_png, unpack_png
from rostether.gateways.rosbridge.request import Request, read_request
from rostether.gateways.rosbridge.rosauth import authenticates
from rostether.gateways.rosbridge.settings import (
    GREETING_LIMIT_S,
    MAX_CONTROL_BYTES,
    MAX_QUEUED_BYTES,
    OPERATION_LIMIT_S,
    TURN_S,
)
from rostether.gateways.rosbridge.status import DEFAULT_LEVEL, StatusLevel, status_message
from rostether.gateways.rosbridge.values import JsonText, write_json
from rostether.gateways.websocket.websocket_stream import WebSocketStream
from rostether.graph.callbacks import report_error
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.text import counted, fold_line

if TYPE_CHECKING:
    from rostether.gateways.rosbridge.rosbridge_context import RosbridgeContext

# How often the client and the log receive a report that a topic is too fast for the client.
_REPORT_INTERVAL_S = 5.0

# Frames are written together up to this size: for small messages, system calls cost most.
_MAX_WRITE_BYTES = 64 << 10

# The limit of different errors of one client in the log; further errors are only sent as statuses.
MAX_LOGGED = 10

# Enough for a message in an image in fragments; deeper nesting has no use.
MAX_DEPTH = 3

# RFC 6455's code for a policy violation.
_CLOSE_POLICY = 1008


class Session:
    """One connection, from its authentication to its end; `name` is the client's address."""

    def __init__(self, connection: WebSocketStream, context: RosbridgeContext, name: str) -> None:
        self._level = DEFAULT_LEVEL
        self.name = name
        self._connection = connection
        self._context = context
        self._outbox: Outbox[ClientSubscription] = Outbox(MAX_QUEUED_BYTES, MAX_CONTROL_BYTES)
        self._topics = topics = ClientTopics(
            context, self._outbox, lambda text: self._report_error(text, None)
        )
        self._services = services = ClientServices(context, self._send)
        self._actions = actions = ClientActions(context, self._send)
        self._fragments = Defragmenter(context.settings.limits.message_bytes)
        self._fragment_ids = count()
        self._depth = 0
        self._logged: set[str] = set()
        self._operations: dict[str, Callable[[Request], Awaitable[object] | None]] = {
            "advertise": topics.advertise,
            "unadvertise": topics.unadvertise,
            "publish": topics.publish,
            "subscribe": topics.subscribe,
            "unsubscribe": topics.unsubscribe,
            "call_service": services.call,
            "advertise_service": self._advertise_service,
            "unadvertise_service": services.unadvertise,
            "service_response": services.answer,
            "send_action_goal": actions.send_goal,
            "cancel_action_goal": actions.cancel_goal,
            "advertise_action": actions.advertise,
            "unadvertise_action": actions.unadvertise,
            "action_feedback": actions.feedback,
            "action_result": actions.result,
            "fragment": self._handle_fragment,
            "png": self._handle_png,
            "set_level": self._set_level,
            "status": _ignore,
            "auth": _ignore,
        }

    async def run(self, *, is_authenticated: bool) -> None:
        """Serve the client until it closes the connection."""
        try:
            async with task_beside(self._send_all()) as sending:
                sending.add_done_callback(self._sending_ended)
                if is_authenticated or await self._authenticate():
                    await self._receive_all()
        finally:
            with contextlib.suppress(RostetherError):
                await asyncio.gather(self._topics.close(), self._services.close(), self._actions.close())

    def _report_status(self, level: StatusLevel, text: str, request_id: object = None) -> None:
        if level <= self._level:
            self._outbox.answer(status_message(level, text, request_id), is_status=True)

    async def _advertise_service(self, request: Request) -> None:
        warning = await self._services.advertise(request)
        if warning:
            self._report_status(StatusLevel.WARNING, warning, request.id)

    def _set_level(self, request: Request) -> None:
        self._level = StatusLevel.read(request.fields.get("level"))

    async def _handle_fragment(self, request: Request) -> None:
        """Handle one piece of a message; after the last one, handle the message."""
        whole = self._fragments.add(request.fields)
        if whole is not None:
            await self._execute_inner(whole)

    async def _handle_png(self, request: Request) -> None:
        """Handle a message that is packed into an image."""
        await self._execute_inner(
            unpack_png(request.text("data"), self._context.settings.limits.message_bytes)
        )

    async def _execute_inner(self, text: str) -> None:
        if self._depth >= MAX_DEPTH:
            raise RemoteProtocolError(f"a message may be packed at most {MAX_DEPTH} times")
        self._depth += 1
        try:
            await self._execute(text)
        finally:
            self._depth -= 1

    async def _authenticate(self) -> bool:
        """Wait for the `auth` message, which must be the first."""
        fields: dict[str, Any] = {}
        with contextlib.suppress(TimeoutError, RemoteProtocolError):
            async with asyncio.timeout(GREETING_LIMIT_S):
                first = await self._connection.receive()
                if first is None:
                    return False
                fields = (await read_request(first)).fields
        if fields.get("op") == "auth" and authenticates(self._context.settings.token, fields, time.time()):
            return True
        reason = "this server requires a token; connect to ws://HOST:PORT/?token=TOKEN, or send op auth first"
        await self._connection.send(status_message(StatusLevel.ERROR, reason))
        self._connection.close(_CLOSE_POLICY, reason)
        self._context.warn(
            f"{self.name} was disconnected because it did not send the token; give it the token"
        )
        return False

    async def _receive_all(self) -> None:
        loop = asyncio.get_running_loop()
        turn_ends_s = 0.0
        async for data in self._connection:
            await self._execute(data)
            if loop.time() >= turn_ends_s:
                await asyncio.sleep(0)
                turn_ends_s = loop.time() + TURN_S

    async def _execute(self, data: str | bytes) -> None:
        request_id: object = None
        try:
            request = await read_request(data)
            request_id = request.id
            operation = self._operations.get(request.op)
            if operation is None:
                known = ", ".join(self._operations)
                raise RemoteProtocolError(f"unknown op {show(request.op)}; known: {known}")
            waiting = operation(request)
            if waiting is not None:
                async with asyncio.timeout(OPERATION_LIMIT_S):
                    await waiting
        except RostetherError as error:
            self._report_error(str(error), request_id)
        except TimeoutError:
            self._report_error(
                f"{request.op}: the graph did not answer within {OPERATION_LIMIT_S:g} s; try again",
                request_id,
            )
        except Exception as error:  # noqa: BLE001 - a client's message must not end its connection
            self._report_error(f"{type(error).__name__}: {error}; please report it", request_id)

    def _report_error(self, text: str, request_id: object) -> None:
        text = fold_line(text)
        self._report_status(StatusLevel.ERROR, text, request_id)
        if len(self._logged) < MAX_LOGGED and text not in self._logged:
            self._logged.add(text)
            last = "; further errors are sent only to the client" if len(self._logged) == MAX_LOGGED else ""
            self._context.warn(f"{self.name}: {text}{last}")

    def _send(self, fields: dict[str, Any], delivery: Delivery) -> None:
        values = fields.get("values")
        if isinstance(values, JsonText):
            others = {name: value for name, value in fields.items() if name != "values"}
            text = f'{write_json(others)[:-1]},"values":{values}}}'
        else:
            text = write_json(fields)
        if delivery.compression is Compression.PNG:
            text = pack_png(text)
        for frame in self._pieces(text, delivery):
            self._outbox.answer(frame)

    def _pieces(self, frame: Frame, delivery: Delivery) -> list[Frame]:
        size = delivery.fragment_bytes or self._context.settings.fragment_bytes
        if size is None or isinstance(frame, bytes) or len(frame) <= size:
            return [frame]
        return list(split_fragments(frame, size, str(next(self._fragment_ids))))

    async def _send_all(self) -> None:
        while not self._outbox.is_overflowing:
            await self._outbox.wait()
            await self._connection.send(*await self._next_frames())
            await asyncio.sleep(0)
        self._context.warn(f"{self.name} does not read its responses, and was disconnected")
        # An orderly close would wait until the client reads the queued data.
        self._connection.abort()

    async def _next_frames(self) -> list[Frame]:
        """Return the frames that fit in one iteration and one write."""
        loop = asyncio.get_running_loop()
        turn_ends_s = loop.time() + TURN_S
        frames: list[Frame] = []
        size = 0
        while size < _MAX_WRITE_BYTES and loop.time() < turn_ends_s:
            item = self._outbox.next()
            if item is None:
                break
            new = await self._frames(item) if isinstance(item, Due) else [item]
            frames += new
            size += sum(map(len, new))
        return frames

    def _sending_ended(self, sending: asyncio.Task[object]) -> None:
        if not sending.cancelled() and (error := sending.exception()) is not None:
            report_error(f"sending to {self.name}", error)
            self._connection.abort()

    async def _frames(self, due: Due[ClientSubscription]) -> list[Frame]:
        subscription = due.receiver
        delivery = subscription.delivery
        try:
            frame = await self._context.forms.published(
                subscription.topic, due.batch, due.index, delivery.compression
            )
        except RostetherError as error:
            subscription.refuse(due.batch.connection, error)
            return []
        frames = self._pieces(frame, delivery)
        self._report_losses(subscription)
        return frames

    def _report_losses(self, subscription: ClientSubscription) -> None:
        lost = subscription.dropped_count - subscription.reported_count
        now_s = asyncio.get_running_loop().time()
        if not lost or now_s < subscription.next_report_s:
            return
        subscription.reported_count += lost
        subscription.next_report_s = now_s + _REPORT_INTERVAL_S
        topic, messages = subscription.topic, counted(lost, "message")
        self._report_status(StatusLevel.WARNING, f"{topic} is too fast for this client: {messages} lost")
        self._context.warn(f"{self.name} reads {topic} too slowly: {messages} lost")


def _ignore(_: Request) -> None:
    """Ignore a client's status, and a repeated authentication."""

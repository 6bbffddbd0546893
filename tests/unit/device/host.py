"""A host for devices under test: a HostLink on a transport, with decoded messages, parameters, services."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

from rostether.errors import TransportError
from rostether.msgdef.registry import Registry
from rostether.rosserial.events import (
    FrameDiscarded,
    HostEvent,
    LogReceived,
    MessagesReceived,
    NegotiationSettled,
    ParameterRequested,
    ServiceAnnounced,
    ServiceRole,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
)
from rostether.rosserial.host_link import HostLink
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.transports.transport import Transport

WAIT_LIMIT_S = 60.0
HOST_TIME = Time(1_700_000_000, 500)
STORE = TypeStore(Registry())

ParamLists = tuple[tuple[int, ...], tuple[float, ...], tuple[str, ...]]


class Host:
    """`messages` by topic, `logs`, `params` for requests, and `answers` by called service."""

    def __init__(self, transport: Transport) -> None:
        self.link = HostLink()
        self.events: list[HostEvent] = []
        self.messages: defaultdict[str, list[Message]] = defaultdict(list)
        self.stray_messages = 0
        self.logs: list[LogReceived] = []
        self.params: dict[str, ParamLists] = {}
        self.answers_params = True
        self.answers: dict[str, Callable[[Message], dict[str, Any] | None]] = {}
        self.announced: dict[tuple[str, TopicRole], TopicAnnounced] = {}
        self.services: dict[str, ServiceAnnounced] = {}
        self.settled = False
        self.lost = False
        self.transport = transport
        self._types: dict[int, tuple[str, str]] = {}
        self._responses: defaultdict[str, list[Message]] = defaultdict(list)
        self._loop = asyncio.get_running_loop()
        self._changed = asyncio.Event()
        self._timer: asyncio.TimerHandle | None = None
        self.link.start(self._loop.time())
        transport.start(self)
        self._flush()

    def data_received(self, data: bytes) -> None:
        self._take(self.link.receive_data(data, self._loop.time()))

    def connection_lost(self, error: TransportError | None) -> None:
        self.lost = True
        if self._timer is not None:
            self._timer.cancel()
        self._changed.set()

    def pause_writing(self) -> None: ...

    def resume_writing(self) -> None: ...

    async def until(self, condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(WAIT_LIMIT_S):
            while not condition():
                self._changed.clear()
                await self._changed.wait()

    def publish(self, topic: str, fields: dict[str, Any]) -> None:
        info = self.announced[topic, TopicRole.SUBSCRIBER].info
        payload = STORE.codec(info.message_type).encode(fields)
        self.transport.write(self.link.encode_message(info.topic_id, payload))

    async def call(self, service: str, fields: dict[str, Any]) -> Message:
        announced = self.services[service]
        payload = STORE.codec(f"{announced.type}Request").encode(fields)
        had = len(self._responses[service])
        self.transport.write(self.link.encode_message(announced.request.topic_id, payload))
        await self.until(lambda: len(self._responses[service]) > had)
        return self._responses[service][had]

    def stop(self) -> None:
        self.link.stop()
        self._flush()

    async def close(self) -> None:
        self.transport.close()
        await self.transport.wait_closed()
        if self._timer is not None:
            self._timer.cancel()

    def _take(self, events: list[HostEvent]) -> None:
        for event in events:
            if not isinstance(event, FrameDiscarded):
                self.events.append(event)
            self._handle(event)
        self._flush()
        self._changed.set()

    def _handle(self, event: HostEvent) -> None:
        match event:
            case TopicAnnounced(role, info):
                self.announced[info.topic_name, role] = event
                self._types[info.topic_id] = (info.topic_name, info.message_type)
            case ServiceAnnounced():
                self.services[event.name] = event
                half = "Response" if event.role is ServiceRole.SERVER else "Request"
                source = event.response if event.role is ServiceRole.SERVER else event.request
                self._types[source.topic_id] = (event.name, f"{event.type}{half}")
            case NegotiationSettled():
                self.settled = True
            case MessagesReceived(topic_id, payloads):
                self._receive(topic_id, payloads)
            case TimeRequested():
                self.link.answer_time(HOST_TIME, self._loop.time())
            case LogReceived():
                self.logs.append(event)
            case ParameterRequested(name) if self.answers_params:
                self.link.answer_parameter(*self.params.get(name, ((), (), ())))

    def _receive(self, topic_id: int, payloads: list[bytes]) -> None:
        name, message_type = self._types[topic_id]
        for payload in payloads:
            if not STORE.layout(message_type).accepts(payload):
                self.stray_messages += 1
                continue
            message = STORE.codec(message_type).decode(payload)
            service = self.services.get(name)
            if service is not None and topic_id == service.request.topic_id:
                self._answer(service, message)
            elif service is not None and topic_id == service.response.topic_id:
                self._responses[name].append(message)
            else:
                self.messages[name].append(message)

    def _answer(self, service: ServiceAnnounced, request: Message) -> None:
        handler = self.answers.get(service.name)
        answer = handler(request) if handler is not None else None
        if answer is not None:
            payload = STORE.codec(f"{service.type}Response").encode(answer)
            self.transport.write(self.link.encode_message(service.response.topic_id, payload))

    def _flush(self) -> None:
        data = self.link.data_to_send()
        if data:
            self.transport.write(data)
        if self._timer is not None:
            self._timer.cancel()
        due_s = self.link.get_timer()
        if due_s is not None and not self.lost:
            self._timer = self._loop.call_later(max(0.0, due_s - self._loop.time()), self._on_timer)

    def _on_timer(self) -> None:
        self._take(self.link.handle_timer(self._loop.time()))


class Hosts:
    """Creates a host for each transport that a listener accepts."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[Host] = asyncio.Queue()
        self._hosts: list[Host] = []

    def __call__(self, transport: Transport) -> None:
        host = Host(transport)
        self._hosts.append(host)
        self._queue.put_nowait(host)

    async def next(self) -> Host:
        async with asyncio.timeout(WAIT_LIMIT_S):
            return await self._queue.get()

    async def close(self) -> None:
        for host in self._hosts:
            await host.close()


@asynccontextmanager
async def hosting(transport: Transport) -> AsyncIterator[Host]:
    host = Host(transport)
    try:
        yield host
    finally:
        await host.close()

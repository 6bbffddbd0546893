"""Messages of a rosbridge client, one per line: after any messages, a call is answered, all in valid JSON.

The graph is in memory, and no socket is opened. The server reports an unexpected exception to the client; in
this harness, such a report is a failure.
"""

from __future__ import annotations

import asyncio
import json
import random
import re
from collections.abc import AsyncIterator
from typing import Any

import cbor2

from fuzz.grammar import near
from fuzz.lowering import lowered
from rostether.gateways.rosbridge import client_services, client_topics, fragments
from rostether.gateways.rosbridge import rosbridge_context as surroundings
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.fragments import split_fragments
from rostether.gateways.rosbridge.message_forms import MessageForms
from rostether.gateways.rosbridge.offered_services import OfferedServices
from rostether.gateways.rosbridge.png_packing import pack_png
from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi
from rostether.gateways.rosbridge.rosbridge_context import RosbridgeContext
from rostether.gateways.rosbridge.service_types import ServiceTypes
from rostether.gateways.rosbridge.session import Session
from rostether.gateways.rosbridge.settings import RosbridgeLimits, RosbridgeSettings
from rostether.gateways.shared_subscriptions import SharedSubscriptions
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

ANSWER_LIMIT_S = 30.0
MAX_EACH = 2
MAX_FRAGMENTS = 6
# Topics that a client unadvertises stay for a while.
MAX_LINGERING = 1
# Then they leave the graph a few turns of the loop later.
SETTLING_TURNS = 20
# The topics that the gateway itself publishes.
OWN = ("/rosout",)
LAST_CALL = '{"op":"call_service","service":"/rosapi/get_time","id":"the end"}'

_MESSAGES: tuple[object, ...] = ({"data": "x"}, {"data": [1, 300]}, {"data": None}, {"x": 1}, [], 5)
_STORE = TypeStore(Registry())
_SETTINGS = RosbridgeSettings(limits=RosbridgeLimits(message_bytes=1 << 16))
_NOT_OURS = re.compile(r"a client: [A-Za-z]*(Error|Exception|Interrupt): ")


def seeds() -> list[bytes]:
    """Return messages of every operation, some in fragments or as PNG."""
    publish = '{"op":"publish","topic":"/pose","msg":{"header":{"stamp":"now"},"pose":{"position":{"x":1}}}}'
    talks = [
        [
            '{"op":"advertise","topic":"/a","type":"std_msgs/String","latch":true,"queue_size":1}',
            '{"op":"publish","topic":"/a","msg":{"data":"x"},"id":"p"}',
            '{"op":"unadvertise","topic":"/a"}',
        ],
        ['{"op":"advertise","topic":"/pose","type":"geometry_msgs/PoseStamped"}', publish],
        [
            '{"op":"advertise","topic":"/b","type":"std_msgs/UInt8MultiArray"}',
            '{"op":"publish","topic":"/b","msg":{"layout":{"dim":[{"label":"a","size":2}]},"data":"AQID"}}',
            '{"op":"publish","topic":"/b","msg":{"data":[1,2,null,1e400,-0.0]}}',
        ],
        *(
            [
                f'{{"op":"subscribe","topic":"/chatter","compression":"{form}","fragment_size":50,"id":1}}',
                '{"op":"unsubscribe","topic":"/chatter","id":1}',
            ]
            for form in ("none", "png", "cbor", "cbor-raw")
        ),
        ['{"op":"subscribe","topic":"/chatter","type":"std_msgs/String","throttle_rate":1,"queue_length":2}'],
        ['{"op":"call_service","service":"/enable","args":{"data":true},"timeout":1,"id":"c"}'],
        ['{"op":"call_service","service":"/enable","args":[false],"fragment_size":20,"compression":"png"}'],
        [
            '{"op":"advertise_service","service":"/mine","type":"std_srvs/srv/SetBool"}',
            '{"op":"call_service","service":"/mine","args":{"data":true},"id":"own"}',
            '{"op":"service_response","service":"/mine","id":"call:1","values":{"success":true},"result":true}',
            '{"op":"unadvertise_service","service":"/mine"}',
        ],
        ['{"op":"set_level","level":"info"}', '{"op":"status","level":"none"}', '{"op":"auth","mac":"x"}'],
        *(
            [f'{{"op":"call_service","service":"/rosapi/{name}","args":{args}}}']
            for name, args in (
                ("topics", "{}"),
                ("get_param", '{"name":"/a","default":"[1]"}'),
                ("set_param", '{"name":"/a/b","value":"{\\"c\\":[1,2.5,null]}"}'),
                ("message_details", '{"type":"sensor_msgs/msg/Image"}'),
                ("node_details", '["/talker"]'),
                ("services_for_type", '{"type":"std_srvs/SetBool"}'),
            )
        ),
        list(split_fragments(publish, 30, "f")),
        [pack_png(publish)],
        list(split_fragments(pack_png(publish), 40, "f")),
    ]
    return ["\n".join(talk).encode() for talk in talks]


def generate(source: random.Random) -> bytes:
    """Return lines of all operations, more of each than the limits allow, some in fragments or as PNG."""
    lines = []
    for _ in range(source.randint(1, 16)):
        line = json.dumps(_operation(source))
        chance = source.random()
        if chance < 0.1:
            pieces = list(split_fragments(line, source.randint(5, 40), source.choice("fg")))
            source.shuffle(pieces)
            lines += pieces
        else:
            lines.append(pack_png(line) if chance < 0.15 else line)
    return "\n".join(lines).encode()


def _operation(source: random.Random) -> dict[str, object]:
    topic = source.choice(("/chatter", "/enable", "a b", *(f"/t{number}" for number in range(8))))
    kind = source.choice(("std_msgs/String", "std_msgs/String", "std_msgs/UInt8MultiArray", "none/None", ""))
    match source.randrange(8):
        case 0 | 1:
            return {"op": "advertise", "topic": topic, "type": kind, "latch": source.random() < 0.5}
        case 2:
            return {"op": source.choice(("unadvertise", "unsubscribe")), "topic": topic}
        case 3:
            message: object = source.choice(_MESSAGES)
            return {"op": "publish", "topic": topic, "msg": message}
        case 4:
            wish = {"compression": source.choice(("none", "png", "cbor", "cbor-raw", "x"))}
            return {"op": "subscribe", "topic": topic, "fragment_size": near(source, 50), **wish}
        case 5:
            args = source.choice(({"data": True}, [False], {}, {"data": "x"}, None))
            return {"op": "call_service", "service": topic, "args": args, "id": source.choice(("c", 1, None))}
        case 6:
            return {"op": "advertise_service", "service": topic, "type": "std_srvs/SetBool"}
        case _:
            total = near(source, MAX_FRAGMENTS)
            number = source.choice((total, total - 1, near(source, total), -1))
            return {
                "op": "fragment",
                "id": source.choice("fghijk"),
                "data": "x",
                "num": number,
                "total": total,
            }


def run(data: bytes) -> None:
    """Send all lines to a server with low limits, and then request the time."""
    with (
        lowered(client_topics, MAX_PUBLICATIONS=MAX_EACH, MAX_SUBSCRIPTIONS=MAX_EACH),
        lowered(client_services, MAX_SERVICES=MAX_EACH),
        lowered(surroundings, MAX_LINGERING=MAX_LINGERING),
        lowered(fragments, MAX_FRAGMENTS=MAX_FRAGMENTS, MAX_UNFINISHED=MAX_EACH),
    ):
        asyncio.run(_converse(data.decode("utf-8", "replace").split("\n")))


class _Connection:
    """Replaces a WebSocket: passes on the client's messages, and checks those that it receives."""

    def __init__(self, lines: list[str], network: MemoryNetwork) -> None:
        self.network = network
        self._lines = lines
        self._answered = asyncio.Event()

    async def __aiter__(self) -> AsyncIterator[str]:
        for line in (*self._lines, LAST_CALL):
            yield line
        async with asyncio.timeout(ANSWER_LIMIT_S):
            await self._answered.wait()
        for _ in range(SETTLING_TURNS):
            await asyncio.sleep(0)
        graph = self.network.snapshot()
        topics = [
            name for name, info in graph.topics.items() if "/gateway" in info.publishers and name not in OWN
        ]
        assert len(topics) <= MAX_EACH + MAX_LINGERING, "more topics are advertised than allowed"
        services = [name for name, info in graph.services.items() if "/gateway" in info.providers]
        assert len(services) <= MAX_EACH, "more services are offered than allowed"

    async def send(self, *frames: str | bytes) -> None:
        """Receive messages in JSON and in CBOR."""
        for frame in frames:
            if isinstance(frame, str):
                self._hear(json.loads(frame, parse_constant=_refuse))
            else:
                self._hear(cbor2.loads(frame))

    def _hear(self, fields: dict[str, object]) -> None:
        assert isinstance(fields["op"], str)
        if fields.get("id") == "the end" and fields.get("service") == "/rosapi/get_time":
            assert fields["result"] is True
            self._answered.set()

    async def receive(self) -> str:
        """Do nothing: no more messages follow."""
        return ""

    def close(self, code: int = 1000, reason: str = "") -> None:
        """Note that the server closes the connection."""
        raise AssertionError(f"connection closed: {code} {reason}")

    def abort(self) -> None:
        """Note that the server aborts the connection."""
        raise AssertionError("connection aborted")


def _refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is not JSON")


def _warn(text: str) -> None:
    assert "\n" not in text
    assert not _NOT_OURS.match(text), text


async def _converse(lines: list[str]) -> None:
    network = MemoryNetwork(now=lambda: Time(5, 6))
    talker = TypedGraph(await network.join("/talker"), _STORE)
    publisher = await talker.publisher("/chatter", "std_msgs/String", latch=True)
    publisher.publish(data="hello")
    await talker.service_server("/enable", "std_srvs/SetBool", _enable)
    graph = await network.join("/gateway")
    around = RosbridgeContext(
        graph,
        _STORE,
        _SETTINGS,
        shared=SharedSubscriptions(graph, _STORE),
        forms=MessageForms(_STORE, Style.ROS1, graph.now),
        service_types=ServiceTypes(graph, _STORE),
        offered=OfferedServices(graph),
        local_services=Rosapi(graph, _STORE, environ={}),
        warn=_warn,
    )
    session = Session(_Connection(lines, network), around, "a client")  # type: ignore[arg-type]
    failures: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: failures.append(context))
    try:
        await session.run(is_authenticated=True)
        assert not failures, failures
    finally:
        await around.close()
        for node in (graph, talker):
            await node.close()


def _enable(request: Message) -> dict[str, bool]:
    return {"success": request.data}

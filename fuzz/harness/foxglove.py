"""Messages of a Foxglove client, one per line: after any messages, a request is answered in valid JSON.

A line of `!` and hexadecimal digits is a binary message. The graph is in memory, and no socket is opened.
"""

from __future__ import annotations

import asyncio
import binascii
import json
import logging
import random
import struct
from collections.abc import Mapping
from pathlib import Path

from fuzz.grammar import near
from fuzz.lowering import lowered
from rostether.gateways.foxglove import client as client_module
from rostether.gateways.foxglove.gateway import DashboardParts, FoxgloveGateway
from rostether.gateways.foxglove.server_messages import StatusLevel
from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings
from rostether.gateways.websocket.access_rules import Rights
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph, Level
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

ANSWER_LIMIT_S = 30.0
MAX_EACH = 2
MAX_MISTAKES = 5
# The topics that the gateway itself publishes.
OWN = ("/rosout",)
# Unadvertised topics leave the graph a few turns of the loop later.
SETTLING_TURNS = 20
LAST_QUESTION = '{"op":"getParameters","parameterNames":["/speed"],"id":"the end"}'

_STORE = TypeStore(Registry())
# The last request must be accepted, after any number of requests.
_SETTINGS = FoxgloveSettings(
    limits=FoxgloveLimits(calls=100_000, subscriptions=MAX_EACH, client_channels=MAX_EACH)
)
_FOLDER = Path(__file__).parent


def seeds() -> list[bytes]:
    """Return messages of every operation."""
    call = struct.pack("<BIII", 2, 1, 5, 4) + b"ros1\1"
    json_call = struct.pack("<BIII", 2, 1, 6, 4) + b'json{"data":true}'
    talks = [
        [
            '{"op":"subscribe","subscriptions":[{"id":0,"channelId":1}]}',
            '{"op":"unsubscribe","subscriptionIds":[0]}',
        ],
        [
            '{"op":"subscribe","subscriptions":[{"id":1,"channelId":1},{"id":2,"channelId":2},{"id":1,"channelId":3}]}'
        ],
        [
            '{"op":"advertise","channels":[{"id":1,"topic":"/a","encoding":"ros1","schemaName":"std_msgs/String"}]}',
            "!" + (struct.pack("<BI", 1, 1) + b"\1\0\0\0x").hex(),
            '{"op":"unadvertise","channelIds":[1]}',
        ],
        [
            '{"op":"advertise","channels":[{"id":3,"topic":"/cmd","encoding":"ros1","schemaName":"geometry_msgs/Twist","driver":"page"}]}',
            "!" + (struct.pack("<BI6d", 1, 3, 0.5, 0, 0, 0, 0, 0)).hex(),
            "!" + (struct.pack("<BI6d", 1, 3, float("nan"), 0, 0, 0, 0, 0)).hex(),
            '{"op":"unadvertise","channelIds":[3]}',
        ],
        [
            '{"op":"listRecordings"}',
            '{"op":"startRecording","topics":["/a"],"format":"mcap"}',
            '{"op":"stopRecording"}',
        ],
        [
            '{"op":"advertise","channels":[{"id":2,"topic":"/b","encoding":"json","schemaName":"my/Own",'
            '"schemaEncoding":"ros1msg","schema":"time t\\nuint8[] b\\nHeader h"}]}',
            "!" + (struct.pack("<BI", 1, 2) + b'{"t":{"sec":1,"nsec":2},"b":"AP8=","h":{"seq":1}}').hex(),
        ],
        ["!" + call.hex(), "!" + json_call.hex()],
        [
            '{"op":"getParameters","parameterNames":[],"id":"a"}',
            '{"op":"getParameters","parameterNames":["/speed","x"]}',
        ],
        [
            '{"op":"subscribeParameterUpdates","parameterNames":["/speed"]}',
            '{"op":"setParameters","parameters":[{"name":"/speed","value":2},{"name":"/b","value":"AP8=","type":"byte_array"}],"id":"s"}',
            '{"op":"setParameters","parameters":[{"name":"/c","value":{"d":[1,2.5,null]}},{"name":"/speed"}]}',
            '{"op":"unsubscribeParameterUpdates","parameterNames":["/speed"]}',
        ],
        ['{"op":"subscribeConnectionGraph"}', '{"op":"unsubscribeConnectionGraph"}'],
        ['{"op":"fetchAsset","uri":"package://harness/foxglove.py","requestId":1}'],
        [
            '{"op":"fetchAsset","uri":"package://harness/../../README.md","requestId":1}',
            '{"op":"fetchAsset","uri":"file:///etc/passwd","requestId":2}',
        ],
    ]
    return ["\n".join(talk).encode() for talk in talks]


def generate(source: random.Random) -> bytes:
    """Return lines of all operations and binary messages, more of each than the limits allow."""
    return "\n".join(_line(source) for _ in range(source.randint(1, 16))).encode()


def _line(source: random.Random) -> str:
    number = source.choice((0, 1, 2, 3, 4, 5, near(source, 3)))
    match source.randrange(7):
        case 0:
            pairs = [{"id": source.randrange(5), "channelId": source.randrange(5)} for _ in range(3)]
            return json.dumps({"op": "subscribe", "subscriptions": pairs})
        case 1 | 2:
            encoding, schema = source.choice(
                (("ros1", "std_msgs/String"), ("json", "std_msgs/String"), ("x", "y"))
            )
            channel = {"id": number, "topic": f"/t{number % 7}", "encoding": encoding, "schemaName": schema}
            return json.dumps({"op": "advertise", "channels": [channel]})
        case 3:
            return json.dumps({"op": source.choice(("unadvertise", "x")), "channelIds": [number]})
        case 4:
            payload = source.choice((b"\1\0\0\0x", b'{"data":"x"}', b"", b"\xff\xff\xff\xff"))
            return "!" + (struct.pack("<BI", 1, number % 2**32) + payload).hex()[: source.choice((6, 100))]
        case 5:
            coding = source.choice((b"ros1", b"json", b"x"))
            size = len(coding) if source.random() < 0.8 else near(source, 4096) % 2**32
            head = struct.pack("<BIII", 2, source.choice((1, 2)), 5, size)
            return "!" + (head + coding + b"\1").hex()[: source.choice((20, 200))]
        case _:
            value = source.choice((1, "x", [1, None], {"a": 1}, 10**400))
            parameter = {"name": source.choice(("/speed", "/b", "a b")), "value": value}
            return json.dumps({"op": "setParameters", "parameters": [parameter], "id": "s"})


def run(data: bytes) -> None:
    """Send all lines to a gateway with low limits, and then request a parameter."""
    with lowered(client_module, MAX_REPORTED_ERRORS=MAX_MISTAKES):
        asyncio.run(_converse(data.decode("utf-8", "replace").split("\n")))


class _Connection:
    """Replaces the connection to a client: checks the messages that it sends."""

    peer = "a client"
    unsent_bytes = 0

    def __init__(self) -> None:
        self.has_room = asyncio.Event()
        self.has_room.set()
        self.answered = asyncio.Event()
        self.mistakes = 0

    def send(self, message: str | bytes) -> None:
        """Check an answer."""
        if isinstance(message, bytes):
            assert message[0] in (2, 3, 4)
            return
        fields = json.loads(message, parse_constant=_refuse)
        assert isinstance(fields["op"], str)
        assert "\n" not in str(fields.get("message", ""))
        self.mistakes += fields["op"] == "status" and fields["level"] == StatusLevel.ERROR
        assert self.mistakes <= MAX_MISTAKES, "more mistakes are reported than allowed"
        if fields.get("id") == "the end":
            self.answered.set()

    def write(self, frames: bytes) -> None:
        """Check the frames of messages of topics."""
        assert frames[0] == 0x82

    def pause_reading(self) -> None:
        """Do nothing."""

    def resume_reading(self) -> None:
        """Do nothing."""


class _Failures(logging.Handler):
    """Keeps failures that would only be logged."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a line of the log."""
        self.texts.append(record.getMessage())


def _refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is not JSON")


def _tell(_: Level, text: str) -> None:
    assert "\n" not in text


def _find_packages() -> Mapping[str, Path]:
    return {"harness": _FOLDER}


async def _converse(lines: list[str]) -> None:
    network = MemoryNetwork(now=lambda: Time(5, 6))
    talker = TypedGraph(await network.join("/talker"), _STORE)
    publisher = await talker.publisher("/chatter", "std_msgs/String", latch=True)
    publisher.publish(data="hello")
    await talker.service_server("/enable", "std_srvs/SetBool", _enable)
    await talker.set_param("/speed", 1.5)
    graph = await network.join("/gateway")

    async def join_teleop() -> Graph:
        return await network.join("/web_teleop")

    parts = DashboardParts(join_teleop=join_teleop)
    gateway = FoxgloveGateway(
        graph, _STORE, _SETTINGS, find_packages=_find_packages, report=_tell, dashboard=parts
    )
    snapshot = await graph.snapshot()
    gateway.context.channels.update(snapshot)
    gateway.context.services.update(snapshot)
    gateway.context.connections.update(snapshot)
    connection = _Connection()
    failed = _Failures()
    logger = logging.getLogger("rostether.graph")
    logger.addHandler(failed)
    try:
        client = gateway.add_client(connection, Rights.FULL)  # type: ignore[arg-type]
        for each in (*lines, LAST_QUESTION):
            client.received(_message(each))
            await asyncio.sleep(0)
        async with asyncio.timeout(ANSWER_LIMIT_S):
            await connection.answered.wait()
        for _ in range(SETTLING_TURNS):
            await asyncio.sleep(0)
        topics = network.snapshot().topics.values()
        own = [topic for topic in topics if "/gateway" in topic.publishers and topic.name not in OWN]
        assert len(own) <= MAX_EACH, "more topics are published than allowed"
        arrived = [topic for topic in topics if "/gateway" in topic.subscribers]
        assert len(arrived) <= MAX_EACH, "more topics are subscribed to than allowed"
        client.closed()
        assert not failed.texts, failed.texts
    finally:
        logger.removeHandler(failed)
        await gateway.close()
        for node in (graph, talker):
            await node.close()


def _message(line: str) -> str | bytes:
    if line.startswith("!"):
        try:
            return binascii.unhexlify(line[1:])
        except ValueError:
            return line
    return line


def _enable(request: Message) -> dict[str, bool]:
    return {"success": request.data}

"""A board at the bridge: after any data, a healthy board on the same connection is served.

The graph is in memory, and the clock jumps. No defect, traceback or report of two lines may appear.
"""

from __future__ import annotations

import asyncio
import random
from typing import Any

from fuzz.harness import host_link
from fuzz.harness.link_script import random_step, step, steps
from rostether.bridge.board_node import BoardNode
from rostether.bridge.session import Session
from rostether.bridge.settings import BridgeSettings
from rostether.errors import TransportError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Level, ParamValue
from rostether.msgdef.registry import Registry
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import FORMS, encode_frame
from rostether.rosserial.packets import ParameterRequest, ParameterResponse, TopicInfo
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.transports.memory import MemoryTransport, memory_pair
from unit.bridge import virtual_time

# On the virtual clock: longer than every negotiation, and than the wait for a silent board.
ANSWER_LIMIT_S = 60.0
SILENCE_S = 20.0
_STORE = TypeStore(Registry())
_STRING = _STORE.registry.message_type("std_msgs/String")
_SET_BOOL = _STORE.registry.service_type("std_srvs/SetBool")
_DONE = b"\1\2\0\0\0ok"
_PARAMETERS: dict[str, ParamValue] = {
    "/gain": 7,
    "/list": [*range(300)],
    "/text": "x" * 300,
    "/tree": {"a": 1},
}
_CALL = (ids.SERVICE_CLIENT_REQUEST, ids.SERVICE_CLIENT_RESPONSE)
_TOPIC_REQUESTS = [encode_frame(ids.TOPIC_REQUEST, b"", version) for version in FORMS]
_QUESTION = encode_frame(ids.PARAMETER, ParameterRequest("gain").encode())
_ANSWERS = [encode_frame(ids.PARAMETER, ParameterResponse((7,)).encode(), version) for version in FORMS]
_RESPONSES = [encode_frame(111, _DONE, version) for version in FORMS]


def seeds() -> list[bytes]:
    """Return scripts with topics, a service that is called, and requests."""
    calls = b"".join(step(kind, info.encode()) for kind, info in _service("/switch", 110))
    ask = step(ids.PARAMETER, ParameterRequest("list").encode(), kind=3)
    return [*host_link.seeds(), step(ids.TIME, bytes(8)) + calls + step(110, b"\1") * 3 + ask * 3]


def generate(source: random.Random) -> bytes:
    """Return a script for the link, with requests for all kinds of parameters, and calls."""
    script = host_link.generate(source)
    if source.random() < 0.5:
        name = source.choice(("/switch", "/broken", "/missing"))
        script += b"".join(step(kind, info.encode()) for kind, info in _service(name, 120))
        script += step(120, source.choice((b"\1", b"", b"\1\1"))) * source.randint(1, 12)
    for _ in range(source.randint(0, 6)):
        name = source.choice(("gain", "list", "text", "tree", "none", "a b", "~x", "/"))
        script += random_step(source, ids.PARAMETER, ParameterRequest(name).encode())
    return script


def run(data: bytes) -> None:
    """Feed a script to a session, then act as a healthy board."""
    virtual_time.run(_converse(data))


def _service(name: str, first_id: int) -> list[tuple[int, TopicInfo]]:
    types = (_SET_BOOL.request, _SET_BOOL.response)
    return [
        (kind, TopicInfo(first_id + index, name, _SET_BOOL.name, types[index].md5sum, 512))
        for index, kind in enumerate(_CALL)
    ]


class _Lines:
    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Check a line of the report."""
        assert "\n" not in text
        assert "please report" not in text, text


class _Board:
    """The board's side of the line."""

    def __init__(self, transport: MemoryTransport) -> None:
        self.transport = transport
        self.received = bytearray()
        self.is_sound = False
        self.error: TransportError | None = None
        self.is_lost = False
        transport.start(self)

    def data_received(self, data: bytes) -> None:
        """Receive the host's data, and answer its topic requests once the script is over."""
        self.received += data
        if self.is_sound and any(request in data for request in _TOPIC_REQUESTS):
            self._announce()

    def connection_lost(self, error: TransportError | None) -> None:
        """Note the end of the connection."""
        self.is_lost = True

    def pause_writing(self) -> None:
        """Do nothing."""

    def resume_writing(self) -> None:
        """Do nothing."""

    def _announce(self) -> None:
        led = TopicInfo(100, "led", _STRING.name, _STRING.md5sum, 512)
        frames = [encode_frame(kind, info.encode()) for kind, info in _service("/switch", 110)]
        announced = encode_frame(ids.SUBSCRIBER, led.encode()) + b"".join(frames)
        self.transport.write(encode_frame(ids.TIME, bytes(8)) + announced)

    async def is_answered(self, question: bytes, answers: list[bytes]) -> bool:
        """Send requests until there is an answer."""
        for _ in range(int(ANSWER_LIMIT_S)):
            self.transport.write(question)
            await asyncio.sleep(1.0)
            if any(answer in self.received for answer in answers):
                return True
        return False


async def _converse(data: bytes) -> None:
    loop = asyncio.get_running_loop()
    failures: list[dict[str, Any]] = []
    loop.set_exception_handler(lambda _, context: failures.append(context))
    network = MemoryNetwork(now=lambda: Time(5, 6))
    peer = await network.join("/peer")
    for name, value in _PARAMETERS.items():
        await peer.set_param(name, value)
    await peer.advertise_service("/switch", _SET_BOOL, _switch)
    await peer.advertise_service("/broken", _SET_BOOL, _fail)
    publisher = await peer.advertise("/a", _STRING, latch=True)
    publisher.publish_raw([b"\1\0\0\0x"])
    graph = await network.join("/board")
    node = BoardNode(graph, _STORE, _Lines(), loop.time, BridgeSettings())
    ours, theirs = memory_pair(can_pause=True)
    board, session = _Board(theirs), Session(ours, node)
    session.start()
    for received, pause_s, _ in steps(data):
        theirs.write(received)
        publisher.publish_raw([b"\1\0\0\0y"])
        await asyncio.sleep(pause_s)
        board.received.clear()
    board.is_sound = True
    await asyncio.sleep(SILENCE_S)
    assert await board.is_answered(_QUESTION, _ANSWERS), "a request is not answered any more"
    assert await board.is_answered(encode_frame(110, b"\1"), _RESPONSES), "a call is not answered any more"
    assert session.is_connected
    assert not board.is_lost
    await session.stop()
    await node.close()
    await peer.close()
    assert not failures, failures


async def _switch(_: bytes) -> bytes:
    return _DONE


async def _fail(_: bytes) -> bytes:
    raise RuntimeError("not today")

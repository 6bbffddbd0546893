"""An example on a simulated board, the bridge, a ROS master and a node that observes the board."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from pathlib import Path

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
from rostether.graph.ports import Graph
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.simulation.simavr.board_events import show_event
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from waiting import until

EXAMPLES = Path(__file__).parents[3] / "client" / "examples"
STORE = TypeStore(Registry())
NODE = "board"
# For a busy machine; on an idle one nothing takes longer than two seconds.
TIMEOUT_S = 60.0

Meets = Callable[[Message], object]
Prepare = Callable[[TypedGraph, str], Awaitable[None]]


async def build_example(name: str | Path, kind: str) -> BuiltFirmware:
    """Build an example, or a sketch elsewhere, with all warnings, once for all test processes."""
    return await build_sketch(EXAMPLES / name, find_board(kind), BuildOptions(warnings=True))


class Ear:
    """Collects the messages of a topic."""

    def __init__(self) -> None:
        self.received: list[Message] = []
        self._came = asyncio.Event()

    def take(self, message: Message) -> None:
        """Store one message."""
        self.received.append(message)
        self._came.set()

    async def next(self, meets: Meets = lambda _message: True, *, timeout_s: float = TIMEOUT_S) -> Message:
        """Return the next message that meets a condition; at the time limit, fail with the last message."""
        seen = len(self.received)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                while True:
                    self._came.clear()
                    for message in self.received[seen:]:
                        if meets(message):
                            return message
                    seen = len(self.received)
                    await self._came.wait()
        raise AssertionError(f"no such message; of {len(self.received)} the last is\n{self.received[-1:]}")

    async def reached(self, count: int) -> None:
        """Wait until `count` messages were received in total."""
        if len(self.received) < count:
            await self.next(lambda _message: len(self.received) >= count)

    async def several(self, count: int) -> list[Message]:
        """Return the next `count` messages."""
        first = len(self.received)
        await self.reached(first + count)
        return self.received[first : first + count]


class Stage:
    """`board` runs the example; `graph` is a node beside the bridge's `/board`."""

    def __init__(
        self, board: SimulatedBoard, graph: TypedGraph, master_uri: str, reporter: RecordingReporter
    ) -> None:
        self.board = board
        self.graph = graph
        self.master_uri = master_uri
        self.reporter = reporter

    async def listen(self, topic: str, type_name: str) -> Ear:
        """Subscribe, and wait until a publisher is connected."""
        ear = Ear()
        codec = STORE.codec(type_name)

        def take(payloads: Sequence[bytes]) -> None:
            for payload in payloads:
                ear.take(codec.decode(payload))

        subscriber = await self.graph.raw.subscribe(topic, STORE.registry.message_type(type_name), take)
        await until(lambda: subscriber.publisher_count, f"a publisher of {topic}")
        return ear

    async def message(self, topic: str, type_name: str, meets: Meets = lambda _message: True) -> Message:
        """Return the next message of a topic that meets a condition."""
        return await (await self.listen(topic, type_name)).next(meets)

    async def log(self) -> Ear:
        """Collect the board's log messages."""
        return await self.listen("/rosout", "rosgraph_msgs/Log")

    async def publisher(self, topic: str, type_name: str) -> TypedPublisher[...]:
        """Advertise a topic, and wait for the board's subscription."""
        publisher = await self.graph.publisher(topic, type_name)
        assert await publisher.wait_for_subscriber(TIMEOUT_S), f"nobody subscribed to {topic}"
        return publisher

    async def service(self, service: str) -> None:
        """Wait until a node offers a service."""
        await _eventually(lambda: self._offers(service), f"service {service}")

    async def memory_becomes(self, symbol: str, data: bytes) -> None:
        """Wait until a variable of the program begins with these bytes."""

        async def has_become() -> bool:
            return await self.board.memory(symbol, len(data)) == data

        await _eventually(has_become, f"{data!r} in {symbol}")

    async def servo_turns(self, pin: str, angle: float) -> None:
        """Wait until a servo is within one degree of an angle."""

        async def stands() -> bool:
            return abs(await self.board.servo_angle(pin) - angle) < 1

        await _eventually(stands, f"{angle} degrees at {pin}")

    async def _offers(self, service: str) -> bool:
        return service in (await self.graph.raw.snapshot()).services


async def _eventually(condition: Callable[[], Awaitable[bool]], what: str) -> None:
    deadline_s = asyncio.get_running_loop().time() + TIMEOUT_S
    while not await condition():
        assert asyncio.get_running_loop().time() < deadline_s, f"gave up waiting for {what}"
        await asyncio.sleep(0.01)


@contextlib.asynccontextmanager
async def a_graph(master_uri: str, name: str = "/onlooker") -> AsyncIterator[TypedGraph]:
    """Join the stage's graph as a node."""
    graph = await _join(master_uri, name)
    try:
        yield TypedGraph(graph, STORE)
    finally:
        await graph.close()


@contextlib.asynccontextmanager
async def a_bridge(master_uri: str, reporter: RecordingReporter, address: str) -> AsyncIterator[Supervisor]:
    """Serve a link address."""

    async def join(
        node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        return await _join(master_uri, node_name, namespace, remappings)

    supervisor = Supervisor(join, STORE, reporter=reporter, settings=BridgeSettings(grace_s=1.0))
    try:
        await supervisor.start([parse_address(address)])
        yield supervisor
    finally:
        await supervisor.close()


@contextlib.asynccontextmanager
async def running(
    name: str | Path,
    kind: str = "uno",
    words: Sequence[str] = (),
    prepare: Prepare | None = None,
    *,
    uses_network: bool = False,
    options: str = "",
) -> AsyncIterator[Stage]:
    """Run an example. `words` are commands to the board at its start; `prepare` is called with the graph
    before that.

    With `uses_network`, the sketch reaches the bridge over the network, at a link address with `options`;
    otherwise on the serial line.
    """
    built = await build_example(name, kind)
    reporter = RecordingReporter()
    async with contextlib.AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        graph = await stack.enter_async_context(a_graph(master.uri))
        if prepare is not None:
            await prepare(graph, master.uri)
        words = list(words)
        if uses_network:
            bridge = await stack.enter_async_context(
                a_bridge(master.uri, reporter, f"tcp://127.0.0.1:0?name={NODE}{options}")
            )
            words.append("network " + bridge.listening_on[0].removeprefix("tcp://").partition("?")[0])
        board = await stack.enter_async_context(
            await SimulatedBoard.start(built.elf, board=kind, commands=words)
        )
        if not uses_network:
            await stack.enter_async_context(a_bridge(master.uri, reporter, f"{board.address}?name={NODE}"))
        try:
            yield Stage(board, graph, master.uri, reporter)
        except AssertionError as error:
            error.add_note("\n".join(["the bridge and the board reported:", *reporter.texts[-10:]]))
            error.add_note("\n".join(show_event(each) for each in list(board.recent)[-10:]))
            raise


@contextlib.asynccontextmanager
async def running_alone(name: str, kind: str = "uno") -> AsyncIterator[SimulatedBoard]:
    """Run an example without a bridge; its serial line is not in use."""
    built = await build_example(name, kind)
    async with await SimulatedBoard.start(built.elf, board=kind) as board:
        yield board


async def _join(
    master_uri: str, name: str, namespace: str = "/", remappings: Mapping[str, str] | None = None
) -> Graph:
    return await join_ros1(
        name,
        environment=RosEnvironment.read({}).with_master(master_uri),
        namespace=namespace,
        remappings=remappings,
    )

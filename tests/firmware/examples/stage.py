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

Condition = Callable[[Message], object]
Prepare = Callable[[TypedGraph, str], Awaitable[None]]


async def build_example(name: str | Path, kind: str) -> BuiltFirmware:
    """Build an example, or a sketch elsewhere, with all warnings, once for all test processes."""
    return await build_sketch(EXAMPLES / name, find_board(kind), BuildOptions(warnings=True))


class TypedInbox:
    """Collects the messages of a topic."""

    def __init__(self) -> None:
        self.messages: list[Message] = []
        self._arrived = asyncio.Event()

    def store(self, message: Message) -> None:
        """Store one message."""
        self.messages.append(message)
        self._arrived.set()

    async def wait_for(
        self, condition: Condition = lambda _message: True, *, timeout_s: float = TIMEOUT_S
    ) -> Message:
        """Return the next message that meets a condition; at the time limit, fail with the last message."""
        seen = len(self.messages)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                while True:
                    self._arrived.clear()
                    for message in self.messages[seen:]:
                        if condition(message):
                            return message
                    seen = len(self.messages)
                    await self._arrived.wait()
        raise AssertionError(f"no such message; of {len(self.messages)} the last is\n{self.messages[-1:]}")

    async def wait_for_count(self, count: int) -> None:
        """Wait until `count` messages were received in total."""
        if len(self.messages) < count:
            await self.wait_for(lambda _message: len(self.messages) >= count)

    async def next_messages(self, count: int) -> list[Message]:
        """Return the next `count` messages."""
        first = len(self.messages)
        await self.wait_for_count(first + count)
        return self.messages[first : first + count]


class Stage:
    """`board` runs the example; `graph` is a node beside the bridge's `/board`."""

    def __init__(
        self, board: SimulatedBoard, graph: TypedGraph, master_uri: str, reporter: RecordingReporter
    ) -> None:
        self.board = board
        self.graph = graph
        self.master_uri = master_uri
        self.reporter = reporter

    async def listen(self, topic: str, type_name: str) -> TypedInbox:
        """Subscribe, and wait until a publisher is connected."""
        inbox = TypedInbox()
        codec = STORE.codec(type_name)

        def store(payloads: Sequence[bytes]) -> None:
            for payload in payloads:
                inbox.store(codec.decode(payload))

        subscriber = await self.graph.raw.subscribe(topic, STORE.registry.message_type(type_name), store)
        await until(lambda: subscriber.publisher_count, f"a publisher of {topic}")
        return inbox

    async def message(
        self, topic: str, type_name: str, condition: Condition = lambda _message: True
    ) -> Message:
        """Return the next message of a topic that meets a condition."""
        return await (await self.listen(topic, type_name)).wait_for(condition)

    async def listen_to_log(self) -> TypedInbox:
        """Collect the board's log messages."""
        return await self.listen("/rosout", "rosgraph_msgs/Log")

    async def publisher(self, topic: str, type_name: str) -> TypedPublisher[...]:
        """Advertise a topic, and wait for the board's subscription."""
        publisher = await self.graph.publisher(topic, type_name)
        assert await publisher.wait_for_subscriber(TIMEOUT_S), f"no subscriber of {topic}"
        return publisher

    async def wait_for_service(self, service: str) -> None:
        """Wait until a node offers a service."""
        await _wait_until(lambda: self._offers(service), f"service {service}")

    async def wait_for_memory(self, symbol: str, data: bytes) -> None:
        """Wait until a variable of the program begins with these bytes."""

        async def has_data() -> bool:
            return await self.board.memory(symbol, len(data)) == data

        await _wait_until(has_data, f"{data!r} in {symbol}")

    async def wait_for_servo(self, pin: str, angle: float) -> None:
        """Wait until a servo is within one degree of an angle."""

        async def is_near() -> bool:
            return abs(await self.board.servo_angle(pin) - angle) < 1

        await _wait_until(is_near, f"{angle} degrees at {pin}")

    async def _offers(self, service: str) -> bool:
        return service in (await self.graph.raw.snapshot()).services


async def _wait_until(condition: Callable[[], Awaitable[bool]], what: str) -> None:
    deadline_s = asyncio.get_running_loop().time() + TIMEOUT_S
    while not await condition():
        assert asyncio.get_running_loop().time() < deadline_s, f"gave up waiting for {what}"
        await asyncio.sleep(0.01)


@contextlib.asynccontextmanager
async def open_graph(master_uri: str, name: str = "/onlooker") -> AsyncIterator[TypedGraph]:
    """Join the stage's graph as a node."""
    graph = await _join(master_uri, name)
    try:
        yield TypedGraph(graph, STORE)
    finally:
        await graph.close()


@contextlib.asynccontextmanager
async def open_bridge(
    master_uri: str, reporter: RecordingReporter, address: str
) -> AsyncIterator[Supervisor]:
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
    commands: Sequence[str] = (),
    prepare: Prepare | None = None,
    *,
    uses_network: bool = False,
    options: str = "",
) -> AsyncIterator[Stage]:
    """Run an example. `commands` are sent to the board at its start; `prepare` gets the graph before that.

    With `uses_network`, the sketch reaches the bridge over the network, at a link address with `options`;
    otherwise on the serial line.
    """
    built = await build_example(name, kind)
    reporter = RecordingReporter()
    async with contextlib.AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        graph = await stack.enter_async_context(open_graph(master.uri))
        if prepare is not None:
            await prepare(graph, master.uri)
        commands = list(commands)
        if uses_network:
            bridge = await stack.enter_async_context(
                open_bridge(master.uri, reporter, f"tcp://127.0.0.1:0?name={NODE}{options}")
            )
            commands.append("network " + bridge.listening_on[0].removeprefix("tcp://").partition("?")[0])
        board = await stack.enter_async_context(
            await SimulatedBoard.start(built.elf, board=kind, commands=commands)
        )
        if not uses_network:
            await stack.enter_async_context(open_bridge(master.uri, reporter, f"{board.address}?name={NODE}"))
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

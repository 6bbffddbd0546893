"""The graph port: the interface of a bridge, a tool or a page to any ROS graph, ROS 1, ROS 2 or in memory.

A `Graph` is one node's membership in a ROS graph. Payloads are ROS 1 serialization without a length
prefix and are never decoded here. Names are resolved by the implementation: relative names against the
node's namespace, `~name` against the node, and through its remappings.

Payloads are passed in batches: a chunk from a board has hundreds of messages, and one call per chunk makes a
flood cheap.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Container, Mapping, Sequence
from enum import IntEnum
from typing import Protocol, TypeAlias, TypedDict, Unpack, runtime_checkable

from msgspec import Struct, field

from rostether.msgdef.interface import ANY_TYPE, MessageType, ServiceType
from rostether.rostime import Time

ParamValue: TypeAlias = bool | int | float | str | bytes | list["ParamValue"] | dict[str, "ParamValue"] | None
OnMessages: TypeAlias = Callable[[Sequence[bytes]], None]
# Called with the header fields of each publisher. It may return the receiver of that publisher's messages;
# graphs that do not distinguish publishers ignore it.
OnConnection: TypeAlias = Callable[[Mapping[str, str]], OnMessages | None]
ServiceHandler: TypeAlias = Callable[[bytes], Awaitable[bytes]]

# In the reason that `Graph.wait_closed` returns when another node has the name now, as rosmaster writes it.
NAME_TAKEN = "new node registered with same name"


class Level(IntEnum):
    """Log severities with the values of rosgraph_msgs/Log."""

    DEBUG = 1
    INFO = 2
    WARN = 4
    ERROR = 8
    FATAL = 16

    @property
    def number_in_tens(self) -> int:
        """The level as the module logging and ROS 2 count it: 10, 20, 30, 40 or 50."""
        return 10 * self.bit_length()


# Passes a line to users with its level.
Report: TypeAlias = Callable[[Level, str], None]


class TopicEntry(Struct, frozen=True):
    """One topic in a snapshot; `type` is `*` until a node registers that knows it."""

    name: str
    type: str
    publishers: tuple[str, ...]
    subscribers: tuple[str, ...]


class ServiceEntry(Struct, frozen=True):
    """One service in a snapshot, with the nodes that provide it.

    `type` is `*` if the graph does not report it: a ROS 1 master does not know it.
    """

    name: str
    providers: tuple[str, ...]
    type: str = ANY_TYPE


class Snapshot(Struct, frozen=True):
    """The whole graph at one moment; every mapping is sorted by name.

    `problem` explains why the graph cannot be read now; the rest is then the last known state.
    """

    nodes: tuple[str, ...] = ()
    topics: Mapping[str, TopicEntry] = field(default_factory=dict)
    services: Mapping[str, ServiceEntry] = field(default_factory=dict)
    problem: str = ""


class SubscribeOptions(TypedDict, total=False):
    """The options of `Graph.subscribe`."""

    # Receives the header fields of each publisher; None by default.
    on_connection: OnConnection | None
    # Whether messages are sent without waiting for others; True by default.
    tcp_nodelay: bool
    # Leaves out the messages of this node itself.
    skip_own: bool
    # Leaves out the messages of these nodes; names may be added and removed at any time.
    skip_nodes: Container[str]
    # For ANY_MESSAGE: adopts the type of the first publisher, and refuses publishers of other types as long
    # as one of this type is connected.
    one_type: bool


class Publisher(Protocol):
    """A handle to publish on one topic."""

    @property
    def topic(self) -> str:
        """The resolved topic name."""

    @property
    def type(self) -> MessageType:
        """The advertised type."""

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""

    @property
    def dropped_count(self) -> int:
        """How many messages slow subscribers have lost so far, in total."""

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        """Queue the payloads for every subscriber, in order.

        Returns False if a subscriber that still reads is above its high-water mark: a caller that can pause
        its source should then await `drained`. Never blocks, and never raises because of a peer.
        """

    async def drained(self, timeout_s: float) -> None:
        """Wait until all backlogs are low, at most `timeout_s`. Each call counts as one pause."""

    async def close(self) -> None:
        """Unadvertise. Idempotent."""


class Subscriber(Protocol):
    """A handle to one subscription."""

    @property
    def topic(self) -> str:
        """The resolved topic name."""

    @property
    def publisher_count(self) -> int:
        """How many publishers are connected now."""

    def pause(self) -> None:
        """Stop reading from publishers, so that they queue on their side."""

    def resume(self) -> None:
        """Read again."""

    async def close(self) -> None:
        """Unsubscribe. Idempotent; no callback runs after it returns."""


class ServiceServer(Protocol):
    """A handle to one advertised service."""

    @property
    def service(self) -> str:
        """The resolved service name."""

    async def close(self) -> None:
        """Unadvertise. Idempotent."""


class ServiceClient(Protocol):
    """A handle to a node's entry as a client of one service."""

    async def close(self) -> None:
        """Remove the client from the graph. Idempotent."""


class Watch(Protocol):
    """A handle to a parameter watch."""

    async def close(self) -> None:
        """Stop watching. Idempotent."""


class Graph(Protocol):
    """One node's membership in a ROS graph.

    Every method that takes a name raises InvalidNameError if the name is invalid. Every method that asks the
    graph raises GraphError if the graph cannot be reached or refuses. On ROS 2, methods also raise
    UnknownTypeError if no definition of a type is found, and SerializationError for values that do not fit.
    """

    @property
    def node_name(self) -> str:
        """The node's fully qualified name."""

    def resolve(self, name: str) -> str:
        """Return the fully qualified, remapped form of a name. Raises InvalidNameError."""

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> Publisher:
        """Advertise a topic. `queue_bytes` limits the backlog of each slow subscriber (None: default).

        A second handle to a topic of this node shares the first one's queues and subscribers; it raises
        TypeMismatchError if its type is different. Raises InvalidNameError, GraphError.
        """

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> Subscriber:
        """Subscribe. `ANY_MESSAGE` accepts every type. Raises InvalidNameError, GraphError."""

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ServiceServer:
        """Offer a service. A handler that raises RostetherError fails the call with that error's text.

        Calls run concurrently. Raises GraphError if this node already offers the service.
        """

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service; without a time limit it waits as long as the server runs.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        InvalidNameError.
        """

    async def get_param(self, name: str) -> ParamValue:
        """Return a parameter's value. Raises UnknownNameError."""

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter; a mapping replaces the whole tree below it."""

    async def delete_param(self, name: str) -> None:
        """Delete a parameter. Raises UnknownNameError."""

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set."""

    async def search_param(self, name: str) -> str | None:
        """Return the full name of the nearest parameter of that name, upward from the node, else None."""

    async def list_params(self) -> list[str]:
        """Return the full names of all parameters, sorted."""

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> Watch:
        """Call back with the value now and whenever it has changed; None means it is unset."""

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change."""

    async def close(self) -> None:
        """Leave the graph: everything advertised, subscribed or watched ends. Idempotent."""

    async def wait_closed(self) -> str:
        """Wait until the node has left, by `close` or by a shutdown request; return the reason.

        A ROS 1 node receives one from `rosnode kill`, and from the master when another node uses its name.
        """


@runtime_checkable
class ListsClients(Protocol):
    """A `Graph` that lists the clients of services, as ROS 2 does; ROS 1 does not know them."""

    async def list_client(self, service: str, service_type: ServiceType) -> ServiceClient:
        """List this node as a client of a service, even if the service does not exist.

        Raises the same errors as `Graph.advertise`.
        """


class JoinGraph(Protocol):
    """Opens a new node on a graph; the bridge calls it once for each board."""

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        """Join as `node_name`. Raises MasterUnreachableError, InvalidNameError, GraphError."""

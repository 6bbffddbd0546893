"""One node in several graphs at once: a board in ROS 1 and in ROS 2.

It publishes, subscribes and serves in all of them. It tries them in order for service calls and parameters. A
graph that fails does not disturb the others; one that joins later gets all open handles.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Container, Coroutine, Sequence
from typing import Any, TypeVar, Unpack

from rostether.errors import (
    DefinitionError,
    GraphError,
    InvalidNameError,
    MasterUnreachableError,
    RostetherError,
    ServiceUnavailableError,
    UnknownNameError,
)
from rostether.graph.joint_handle import JointHandle
from rostether.graph.joint_handles import (
    JointPublisher,
    JointServiceServer,
    JointSubscriber,
    JointWatch,
    UnlistedClient,
)
from rostether.graph.node_membership import NodeMembership
from rostether.graph.ports import (
    Graph,
    Level,
    ListsClients,
    OnMessages,
    ParamValue,
    ServiceClient,
    ServiceHandler,
    Snapshot,
    SubscribeOptions,
)
from rostether.graph.snapshots import ChangeSignal, follow_changes, follow_each, merge_snapshots
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.rostime import Time

HandleT = TypeVar("HandleT", bound=JointHandle[Any])
ResultT = TypeVar("ResultT")


class JointGraph(NodeMembership):
    """A `graph.ports.Graph` over others, the most important first; all are closed with it.

    `joint_nodes` are the names of all nodes in the same graphs: only the first graph delivers their messages.
    `relays` are the nodes between these graphs: their messages come from the original publishers.
    """

    def __init__(
        self, graphs: Sequence[Graph], joint_nodes: Container[str] = (), relays: Container[str] = ()
    ) -> None:
        self._graphs = list(graphs)
        self._first = self._graphs[0]
        super().__init__(self._first.node_name, "/", {})
        self._joint_nodes = joint_nodes
        self._relays = relays
        self._handles: list[JointHandle[Any]] = []
        self._joined = ChangeSignal()
        self._watching = {asyncio.ensure_future(self._watch_closed(graph)) for graph in self._graphs}
        self._background: set[asyncio.Task[None]] = set()

    def run_until_closed(self, work: Coroutine[Any, Any, None]) -> None:
        """Run `work` until the node leaves the graphs."""
        start_task(self._background, work)

    async def add(self, graph: Graph, position: int) -> None:
        """Join another graph, of rank `position`, with all publishers, subscribers, services and watches."""
        self._graphs.insert(position, graph)
        self._watching.add(asyncio.ensure_future(self._watch_closed(graph)))
        self._joined.notify()
        await asyncio.gather(*(handle.add(graph) for handle in self._open_handles()))

    def resolve(self, name: str) -> str:
        """Return the fully qualified, remapped form of a name. Raises InvalidNameError."""
        return self._first.resolve(name)

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> JointPublisher:
        """Advertise a topic in all graphs. Raises their errors if none accepts it."""
        name = self.resolve(topic)
        return await self._open(JointPublisher(name, message_type, latch=latch, queue_bytes=queue_bytes))

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> JointSubscriber:
        """Subscribe in all graphs. Raises their errors if none accepts it."""
        subscriber = JointSubscriber(
            self.resolve(topic),
            message_type,
            on_messages,
            first=self._first,
            options=options,
            joint_nodes=self._joint_nodes,
            relays=self._relays,
        )
        return await self._open(subscriber)

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> JointServiceServer:
        """Offer a service in all graphs. Raises GraphError if this node offers it already."""
        name = self.resolve(service)
        if any(
            isinstance(each, JointServiceServer) and each.service == name for each in self._open_handles()
        ):
            raise GraphError(f"this node already offers the service {name}; choose another name")
        return await self._open(JointServiceServer(name, service_type, handler))

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service in the first graph that has it. Raises the errors of `Graph.call_service`."""
        # After these errors, it tries the next graph, which may know the type or accept the name.
        return await self._first_of(
            lambda graph: graph.call_service(service, service_type, request, timeout_s=timeout_s),
            ServiceUnavailableError,
            MasterUnreachableError,
            DefinitionError,
            InvalidNameError,
        )

    async def list_client(self, service: str, service_type: ServiceType) -> ServiceClient:
        """List this node as a client of a service, in all graphs that list clients."""
        name = self.resolve(service)

        async def list_in(graph: Graph) -> ServiceClient:
            if isinstance(graph, ListsClients):
                return await graph.list_client(name, service_type)
            return UnlistedClient()

        return await self._open(JointHandle(f"client of {name}", list_in))

    async def get_param(self, name: str) -> ParamValue:
        """Return a parameter's value from the first graph that has it. Raises UnknownNameError."""
        return await self._first_of(lambda graph: graph.get_param(name), RostetherError)

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter in the first graph that has it, else in the first that accepts it."""
        having = [graph for graph in self._graphs if await _answers(graph.has_param(name))]
        await self._first_of(
            lambda graph: graph.set_param(name, value), RostetherError, graphs=having or self._graphs
        )

    async def delete_param(self, name: str) -> None:
        """Delete a parameter in the first graph that has it. Raises UnknownNameError."""
        await self._first_of(lambda graph: graph.delete_param(name), RostetherError)

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set in any graph."""
        return any(await self._all(lambda graph: graph.has_param(name)))

    async def search_param(self, name: str) -> str | None:
        """Return the nearest parameter of that name in the first graph that has one, else None."""
        found = await self._all(lambda graph: graph.search_param(name))
        return next((each for each in found if each is not None), None)

    async def list_params(self) -> list[str]:
        """Return the full names of all parameters of all graphs, sorted."""
        names: set[str] = set()
        for found in await self._all(lambda graph: graph.list_params()):
            names.update(found)
        return sorted(names)

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> JointWatch:
        """Call back with the value of the first graph that has one, now and after each change."""
        watch = await self._open(JointWatch(self.resolve(name), on_change, lambda: self._graphs))
        watch.start()
        return watch

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on every graph's /rosout."""
        for graph in self._graphs:
            graph.log(level, text)

    def now(self) -> Time:
        """Return the first graph's time."""
        return self._first.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of all graphs together. Raises the first error if none of them answers."""
        return merge_snapshots(await self._all(lambda graph: graph.snapshot()))

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change in any graph."""
        return follow_changes(lambda: self._graphs, self._joined, self._closed)

    def changes_of_each(self) -> AsyncGenerator[list[Snapshot]]:
        """Yield a snapshot of each graph now and after each change in any of them."""
        return follow_each(lambda: self._graphs, self._joined, self._closed)

    async def _open(self, handle: HandleT) -> HandleT:
        self._check_open()
        # The handle is listed before it opens, so that a graph that joins in the meantime finds it.
        self._handles = [*self._open_handles(), handle]
        try:
            await handle.open(tuple(self._graphs))
        except BaseException:
            handle.stop()
            raise
        return handle

    def _open_handles(self) -> list[JointHandle[Any]]:
        return [handle for handle in self._handles if not handle.is_closed]

    async def _first_of(
        self,
        ask: Callable[[Graph], Awaitable[ResultT]],
        *passing: type[RostetherError],
        graphs: Sequence[Graph] = (),
    ) -> ResultT:
        """Return the answer of the first graph that answers; after the errors `passing`, try the next one."""
        faults: list[RostetherError] = []
        for graph in graphs or self._graphs:
            try:
                return await ask(graph)
            except passing as fault:
                faults.append(fault)
        # A graph that does not answer must not hide the answers of the others.
        answered = (UnknownNameError, ServiceUnavailableError)
        raise next((fault for fault in faults if isinstance(fault, answered)), faults[0])

    async def _all(self, ask: Callable[[Graph], Awaitable[ResultT]]) -> list[ResultT]:
        """Return the answers of all graphs that answer. Raises the first error if none does."""
        results = await asyncio.gather(*map(ask, self._graphs), return_exceptions=True)
        answers = [result for result in results if not isinstance(result, BaseException)]
        faults = [result for result in results if isinstance(result, BaseException)]
        unexpected = [fault for fault in faults if not isinstance(fault, RostetherError)]
        if unexpected or not answers:
            raise (unexpected or faults)[0]
        return answers

    async def _watch_closed(self, graph: Graph) -> None:
        reason = await graph.wait_closed()
        if self._closing is None:
            self._reason = self._reason or reason
            self._closed.set()

    async def _end(self) -> None:
        await cancel_all(*self._watching, *self._background)
        for handle in self._open_handles():
            handle.stop()
        results = await asyncio.gather(*(graph.close() for graph in self._graphs), return_exceptions=True)
        for result in results:
            if isinstance(result, BaseException):
                raise result


async def _answers(question: Awaitable[bool]) -> bool:
    try:
        return await question
    except RostetherError:
        return False

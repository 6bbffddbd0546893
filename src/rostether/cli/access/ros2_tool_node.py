"""The node of a tool on a ROS 2 graph: hidden from listings, with ROS 2 messages."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar, cast

from rostether.cli.access.graph_options import GraphOptions, Middleware
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.shell.output import warn
from rostether.errors import GraphError, UnknownTypeError
from rostether.mechanisms.block_end import closed_at_end
from rostether.names.graph_name import is_hidden
from rostether.ros2.endpoint_info import EndpointKind, Ros2Graph
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.graph_view import GraphView
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.ros2.types.type_support import Ros2Types
    from rostether.ros2.zenoh.node import ZenohGraph

T = TypeVar("T")

HIDDEN_NAME = "/_rostether"
# A snapshot comes from memory; a user does not notice this delay.
POLL_INTERVAL_S = 0.05
# The longest wait for a given name. DDS announces a name immediately, and again after 3 s if that is lost;
# zenoh's router already knows the names when the command starts.
PATIENCE_S = {Middleware.ZENOH: 1.0, Middleware.RCLPY: 4.0}
# A longer warning would not fit on a line.
MAX_SHOWN_DOMAINS = 8
# A listing is complete when nothing new arrived for this long.
QUIET_S = {Middleware.ZENOH: 0.1, Middleware.RCLPY: 0.8}


@dataclass(eq=False, slots=True)
class ToolNode:
    """The node of one command on a ROS 2 graph; `line` names the graph that it has joined, for users."""

    graph: TypedGraph
    registry: NativeRegistry
    types: Ros2Types
    middleware: Middleware
    is_linked: Callable[[], bool]
    line: str
    _is_other_domain_reported: bool = False

    async def snapshot(self) -> GraphView:
        """Return the current graph without this node."""
        raw = cast("Ros2Graph", self.graph.raw)
        own = raw.node_name
        ends = [end for end in await raw.endpoints() if end.node_name != own]
        return GraphView([node for node in (await raw.snapshot()).nodes if node != own], ends)

    async def learn_type(
        self, view: GraphView, name: str, kind: EndpointKind = EndpointKind.PUBLISHER
    ) -> None:
        """Ask the first publisher of a topic, or server of a service, for its type, unless the type is known.

        Raises UnknownTypeError if that node does not describe the type.
        """
        from rostether.ros2.type_description import learn_type

        registry = self.registry
        look = registry.service_type if kind is EndpointKind.SERVER else registry.message_type
        end = next(iter(view.of(kind, name)), None)
        if end is None:
            return
        try:
            look(end.type)
        except UnknownTypeError as error:
            try:
                await learn_type(self.graph.raw, self.types, end.node_name, end.type, end.type_hash)
            except UnknownTypeError as reason:
                raise UnknownTypeError(f"{error}; {reason}") from None

    async def settled_snapshot(self) -> GraphView:
        """Return the graph once it seems complete and unchanged for a while, or at a time limit."""
        quiet_s, loop = QUIET_S[self.middleware], asyncio.get_running_loop()
        view = await self.snapshot()
        begin_s = changed_s = loop.time()
        while loop.time() - begin_s < PATIENCE_S[self.middleware]:
            if _looks_complete(view) and loop.time() - changed_s >= quiet_s:
                break
            await asyncio.sleep(POLL_INTERVAL_S)
            latest = await self.snapshot()
            if latest != view:
                view, changed_s = latest, loop.time()
        await self._report_other_domains(view)
        return view

    async def snapshot_when(self, condition: Callable[[GraphView], bool]) -> GraphView:
        """Return the graph as soon as it meets the condition, or at a time limit."""
        deadline_s = asyncio.get_running_loop().time() + PATIENCE_S[self.middleware]
        view = await self.snapshot()
        while not condition(view) and asyncio.get_running_loop().time() < deadline_s:
            await asyncio.sleep(POLL_INTERVAL_S)
            view = await self.snapshot()
        await self._report_other_domains(view)
        return view

    async def _report_other_domains(self, view: GraphView) -> None:
        """Write a line if this domain has no nodes but others have: ROS_DOMAIN_ID is a common mistake."""
        if (
            self.middleware is not Middleware.ZENOH
            or self._is_other_domain_reported
            or not all(map(is_hidden, view.nodes))
        ):
            return
        self._is_other_domain_reported = True
        domains = await cast("ZenohGraph", self.graph.raw).other_domains()
        if domains:
            shown = ", ".join(map(str, domains[:MAX_SHOWN_DOMAINS]))
            warn(f"this ROS 2 domain has no nodes; there are nodes in domain {shown}; check ROS_DOMAIN_ID")


def _looks_complete(view: GraphView) -> bool:
    """Return whether a node and the endpoints of each node are known: nodes are announced first."""
    with_endpoints = {endpoint.node_name for endpoint in view.endpoints}
    return any(not is_hidden(node) for node in view.nodes) and with_endpoints.issuperset(view.nodes)


@asynccontextmanager
async def tool_node(
    options: GraphOptions,
    msg_paths: Iterable[Path] = (),
    *,
    is_quiet: bool = False,
    needs_router: bool = False,
    needs_definitions: bool = True,
) -> AsyncIterator[ToolNode]:
    """Run a hidden node until the end of the block; if `is_quiet`, without advice about a missing router.

    With `needs_router`, a missing zenoh router is an error, not a warning. Without `needs_definitions`,
    messages of unknown types are delivered as CDR.

    Raises ConfigError, GraphError with advice.
    """
    from rostether.graph.typed_graph import TypedGraph
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.ros2.types.native_types import NativeClasses, NativeTypes
    from rostether.ros2.types.undefined_types import UndefinedTypes
    from rostether.serde.store import TypeStore

    middleware = options.ros2
    assert middleware is not None
    registry = NativeRegistry.from_environment(msg_paths)
    # A tool runs briefly: it must not be the router that others depend on.
    reach = ZenohReach(RouterChoice.NEVER)
    types = NativeTypes(registry) if needs_definitions else UndefinedTypes(registry, asks_nodes=False)
    async with ros2_access(middleware, reach=reach, types=types) as access:
        if middleware is Middleware.ZENOH and not is_quiet:
            await warn_without_router(is_error=needs_router)
        graph = await access.join(
            options.node_name(HIDDEN_NAME), namespace=options.arguments.get("__ns", "/")
        )
        async with closed_at_end(graph):
            yield ToolNode(
                TypedGraph(graph, TypeStore(registry, NativeClasses(registry))),
                registry,
                types,
                middleware,
                access.is_linked,
                access.line,
            )


async def warn_without_router(*, is_error: bool = False) -> None:
    """Advise the user if no zenoh router answers: nodes cannot be found without one.

    Raises GraphError with the advice if `is_error`.
    """
    from rostether.ros2.zenoh.configuration import ROUTER_ENDPOINT, configures_endpoints, is_router_there

    if not configures_endpoints(Ros2Environment.read()) and not await is_router_there():
        advice = (
            f"no zenoh router answers at {ROUTER_ENDPOINT}, so nodes cannot be found; start one with "
            "`rostether core --ros2 zenoh`, `rostether serve --ros2 zenoh`, or ROS 2's rmw_zenohd"
        )
        if is_error:
            raise GraphError(advice)
        warn(advice)


async def asked(options: GraphOptions, question: Callable[[ToolNode], Awaitable[T]]) -> T:
    """Ask the graph one question, and return the answer.

    Raises the errors of `tool_node` and of the question.
    """
    # Without a router, a list would be empty, as if no nodes were running.
    async with tool_node(options, needs_router=True) as tool:
        answer = await question(tool)
        if not tool.is_linked():
            raise GraphError(
                "no zenoh router answers at the configured endpoints, so nodes cannot be found; "
                "`rostether doctor --ros2 zenoh` shows the reason"
            )
        return answer

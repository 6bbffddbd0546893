"""One zenoh session of a process, which carries the nodes of many boards."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import zenoh

from rostether.errors import ConfigError, MasterUnreachableError
from rostether.graph.ports import ParamValue
from rostether.names.graph_name import join
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.handover import Handover
from rostether.ros2.naming import validate_node_name
from rostether.ros2.types.type_support import Ros2Types
from rostether.ros2.zenoh.access_check import find_denied_topics
from rostether.ros2.zenoh.configuration import (
    ROUTER_ENDPOINT,
    configures_endpoints,
    is_router_there,
    one_line,
    peer_configuration,
    router_configuration,
)
from rostether.ros2.zenoh.node import ZenohGraph
from rostether.ros2.zenoh.reachability import (
    NO_SESSION,
    endpoints_of,
    find_faults,
    find_listen_fault,
    tls_of,
    uses_tls,
)
from rostether.ros2.zenoh.refusals import report_refusals
from rostether.ros2.zenoh.shared_session import SharedSession
from rostether.ros2.zenoh.thread_state import keep_thread_state
from rostether.ros2.zenoh.tokens import all_tokens
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

# The limit of changes of the graph that wait for the event loop: twice the limit of tokens.
MAX_WAITING_TOKENS = 200_000

# How long a new session waits for the state of the graph; a running router answers immediately.
FIRST_QUERY_TIMEOUT_S = 2.0

# How long a session waits for its first connection (zenoh does not wait); a local router needs 10 ms.
FIRST_LINK_TIMEOUT_S = 0.5

# The delay of the access check: by then, the program has its first topics, and rules for later ones are
# usually the same.
ACCESS_CHECK_AFTER_S = 1.0

# The interval between checks for the first connection; each check takes microseconds.
LINK_POLL_S = 0.005

# The interval between checks whether a router is connected; each check takes microseconds.
_CHECK_S = 1.0

_log = logging.getLogger("rostether.ros2")


class ZenohSession(SharedSession):
    """A session; `join` is a `JoinGraph`. Create it with `ZenohSession.open`."""

    def __init__(self, session: zenoh.Session, environment: Ros2Environment, types: Ros2Types) -> None:
        super().__init__(session, environment.domain_id, types)
        self.is_router = False
        self.listens_on: tuple[str, ...] = ()
        self.connects_to: tuple[str, ...] = ()
        self._is_closed = False
        self._token_queue: Handover[tuple[str, bool]] = Handover(
            self.graph.apply_tokens, limit=MAX_WAITING_TOKENS
        )
        self._watch: zenoh.Subscriber[None] | None = None
        self._tasks: list[asyncio.Task[None]] = []

    @classmethod
    async def open(
        cls, environment: Ros2Environment, types: Ros2Types, *, reach: ZenohReach | None = None
    ) -> ZenohSession:
        """Open a session that connects to a router or is the router of this machine, according to `reach`.

        Raises ConfigError, and MasterUnreachableError if zenoh cannot open it.
        """
        reach = reach or ZenohReach()
        is_router = await _replaces_router(environment, reach)
        configuration = (router_configuration if is_router else peer_configuration)(environment, reach)
        try:
            session = await _open_session(configuration)
        except MasterUnreachableError:
            if not is_router or reach.router is RouterChoice.ALWAYS or not await is_router_there():
                raise
            # Another process became the router first.
            is_router, configuration = False, peer_configuration(environment, reach)
            session = await _open_session(configuration)
        opened = cls(session, environment, types)
        opened.is_router = is_router
        return await opened._start(configuration)

    async def join(
        self,
        node_name: str,
        *,
        namespace: str = "/",
        remappings: Mapping[str, str] | None = None,
        parameters: Mapping[str, ParamValue] | None = None,
    ) -> ZenohGraph:
        """Join as `node_name`, with initial values of its parameters. Raises InvalidNameError, GraphError."""
        if self._is_closed:
            raise MasterUnreachableError("this zenoh session is closed; open another one")
        full_name = validate_node_name(join(namespace, node_name))
        graph = ZenohGraph(self, full_name, namespace, remappings or {}, parameters or {})
        self.nodes.add(graph)
        try:
            await graph.open()
        except BaseException:
            await graph.close()
            raise
        return graph

    async def close(self) -> None:
        """Close every node, then the session. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*(graph.close("the session ended") for graph in list(self.nodes)))
        self._token_queue.close()
        await asyncio.to_thread(self._end)

    def _end(self) -> None:
        self.zenoh.close()
        self.put_threads.shutdown()
        self.call_threads.shutdown(cancel_futures=True)

    async def _start(self, configuration: zenoh.Config) -> ZenohSession:
        self.listens_on = endpoints_of(configuration, "listen")
        # The default endpoint is on this machine: nothing but a missing router can be wrong there.
        named = [each for each in endpoints_of(configuration, "connect") if each != ROUTER_ENDPOINT]
        self.connects_to = tuple(named)
        if not self.is_router:
            await self._wait_for_link()
        if named:
            # Runs in the background, because a machine that is off is detected only after a second.
            self._tasks.append(asyncio.ensure_future(self._report_faults(named, configuration)))
        if named or not self.is_router:
            watching = _watch_router(self.zenoh, named, self.graph.set_problem)
            self._tasks.append(asyncio.ensure_future(watching))
        key = all_tokens(self.domain_id)
        self._watch = self.liveliness.declare_subscriber(
            key, zenoh.handlers.Callback(self._handle_token, indirect=False), history=True
        )
        # A snapshot or service call right after the start must see the existing endpoints.
        started_s = time.monotonic()
        tokens = await self.query_tokens(key, FIRST_QUERY_TIMEOUT_S)
        await asyncio.sleep(0)
        _log.debug("%d tokens after %.3f s", len(tokens), time.monotonic() - started_s)
        return self

    async def _wait_for_link(self) -> None:
        """Wait for the first connection: a query sent earlier reaches no peer."""
        deadline_s = time.monotonic() + FIRST_LINK_TIMEOUT_S
        # Zenoh does not report connections; polling is cheap.
        while not self.is_linked() and time.monotonic() < deadline_s:  # noqa: ASYNC110
            await asyncio.sleep(LINK_POLL_S)

    def is_linked(self) -> bool:
        """Return whether a router or another peer is connected."""
        info = self.zenoh.info
        return bool(info.routers_zid() or info.peers_zid())

    async def _report_faults(self, named: Sequence[str], configuration: zenoh.Config) -> None:
        await self._report_unreachable(named, tls_of(configuration))
        await asyncio.sleep(ACCESS_CHECK_AFTER_S)
        for endpoint in named if self.is_linked() else ():
            tokens = [token for _, token in self.graph.all_endpoints() if token.session_id == self.session_id]
            denied = await find_denied_topics(configuration, endpoint, self.domain_id, tokens)
            if denied:
                _log.warning(
                    "access denied: the router at %s does not forward %s for this program; allow it in the "
                    "router's access_control section",
                    endpoint,
                    ", ".join(denied),
                )

    async def _report_unreachable(self, named: Sequence[str], tls: Mapping[str, Any]) -> None:
        """Report once which configured endpoints cannot be reached, and why."""
        faults = await find_faults(named, tls)
        if self.is_router:
            await self._wait_for_link()
        if not faults and not self.is_linked():
            faults = dict.fromkeys(named, NO_SESSION)
        for endpoint, fault in faults.items():
            _log.warning("no zenoh router answers at %s yet (still trying): %s", endpoint, fault)

    def _handle_token(self, sample: zenoh.Sample) -> None:
        keep_thread_state()
        key = str(sample.key_expr)
        # The session's own tokens are ignored here: zenoh reports them as removed to a client that loses its
        # router.
        if f"/{self.session_id}/" not in key:
            self._token_queue.put((key, sample.kind == zenoh.SampleKind.PUT))


async def _replaces_router(environment: Ros2Environment, reach: ZenohReach) -> bool:
    if reach.router is not RouterChoice.AUTO:
        return reach.router is RouterChoice.ALWAYS
    if reach.connect or configures_endpoints(environment):
        return False
    return not await is_router_there(ROUTER_ENDPOINT)


async def _open_session(configuration: zenoh.Config) -> zenoh.Session:
    """Open a session. Raises ConfigError if zenoh refuses the configuration, else MasterUnreachableError."""
    if uses_tls(endpoints_of(configuration, "listen")):
        report_refusals()
    try:
        # Opening blocks until the first connections are established or have failed.
        return await asyncio.to_thread(zenoh.open, configuration)
    except zenoh.ZError as error:
        text = one_line(error)
        if fault := find_listen_fault(configuration):
            raise MasterUnreachableError(f"zenoh cannot listen: {fault}") from error
        if "listener" in text:
            advice = "check the listen endpoints of the configuration"
            if "in use" in text:
                advice = "stop the program that uses the port, or choose another endpoint"
            raise MasterUnreachableError(f"zenoh cannot listen: {text}; {advice}") from error
        raise MasterUnreachableError(
            f"zenoh cannot open a session: {text}; check the endpoints and the zenoh configuration"
        ) from error
    except Exception as error:
        raise ConfigError(
            f"zenoh does not accept its configuration: {one_line(error)}; correct the file or the variable"
        ) from error


async def _watch_router(session: zenoh.Session, named: Sequence[str], report: Callable[[str], None]) -> None:
    """Report when no router is connected, and an empty text when one is connected again, until canceled.

    Zenoh does not report it. `named` are the endpoints in the configuration. If none of them ever answered,
    that is also a problem, except while other peers are connected: a network of peers needs no router.
    """
    where = f" at {', '.join(named)}" if named else ""
    problem = f"the zenoh router{where} does not answer"
    had_router = False
    while True:
        info = session.info
        has_router = bool(info.routers_zid())
        had_router |= has_router
        is_lost = not has_router and (had_router or (bool(named) and not info.peers_zid()))
        report(problem if is_lost else "")
        await asyncio.sleep(_CHECK_S)

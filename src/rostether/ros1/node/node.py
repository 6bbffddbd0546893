"""A node of a ROS 1 graph: the graph port over a master, XML-RPC and TCPROS."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from functools import partial
from typing import Unpack

from rostether.errors import UnknownNameError
from rostether.graph.log_message import LOG_TYPE, ROSOUT, encode_log
from rostether.graph.node_membership import NodeMembership
from rostether.graph.parameter_watch import ParameterWatch
from rostether.graph.ports import Level, OnMessages, ParamValue, ServiceHandler, Snapshot, SubscribeOptions
from rostether.graph.ros_clock import CLOCK_TOPIC, CLOCK_TYPE
from rostether.graph.snapshots import SharedSnapshots
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.names.graph_name import join, validate_name
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.clock import Clock
from rostether.ros1.node.endpoint_handles import Endpoints
from rostether.ros1.node.graph_view import take_snapshot, watch_changes
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.own_registrations import DEFAULT_CHECK_INTERVAL_S
from rostether.ros1.node.publication import Publication, Publisher
from rostether.ros1.node.service_client import ServiceClient
from rostether.ros1.node.service_server import ServiceServer
from rostether.ros1.node.subscription import Subscription
from rostether.rostime import Time

_log = logging.getLogger("rostether.ros1")

USE_SIM_TIME = "/use_sim_time"


async def join_ros1(
    node_name: str,
    *,
    environment: RosEnvironment | None = None,
    namespace: str = "/",
    remappings: Mapping[str, str] | None = None,
    check_interval_s: float = DEFAULT_CHECK_INTERVAL_S,
    on_leave: Callable[[str], None] | None = None,
) -> Ros1Graph:
    """Join the graph of a master as `node_name`; the master shuts down another node of that name.

    The environment is read from os.environ by default. Every `check_interval_s` the node asks the master
    whether it is still registered. On a shutdown request it leaves immediately, or calls `on_leave` with the
    reason if that is given.
    Raises MasterUnreachableError, InvalidNameError, ConfigError, GraphError.
    """
    environment = environment or RosEnvironment.read()
    full_name = join(namespace, validate_name(node_name))
    master = MasterClient(environment.master_uri, full_name, max_body_bytes=environment.limits.body_bytes)
    graph = Ros1Graph(master, environment, namespace, remappings or {}, on_leave)
    try:
        await graph._open(check_interval_s)
    except BaseException:
        await graph.close()
        raise
    return graph


class Ros1Graph(NodeMembership):
    """Implements `graph.ports.Graph`; created by `join_ros1`."""

    def __init__(
        self,
        master: MasterClient,
        environment: RosEnvironment,
        namespace: str,
        remappings: Mapping[str, str],
        on_leave: Callable[[str], None] | None = None,
    ) -> None:
        super().__init__(master.caller_id, namespace, remappings)
        self._on_leave = on_leave
        self._master = master
        self._snapshots = SharedSnapshots(partial(take_snapshot, master))
        self._limits = environment.limits
        self._clock = Clock()
        self._endpoints = Endpoints(master, environment, report=self._report, on_shutdown=self._leave)
        self._rosout = RosoutLog(
            self.node_name,
            now=self._clock.now,
            published_topics=lambda: [each.topic for each in self._endpoints.publications],
        )

    @property
    def node_uri(self) -> str:
        """The URI of this node's slave API."""
        return self._endpoints.node_uri

    @property
    def master_uri(self) -> str:
        """The URI of the master."""
        return self._master.uri

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> Publisher:
        """Advertise a topic. `queue_bytes` limits the backlog of each slow subscriber (None: default)."""
        self._check_open()
        return await self._endpoints.advertise(
            self.resolve(topic), message_type, latch=latch, queue_bytes=queue_bytes
        )

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> Subscription:
        """Subscribe. `ANY_MESSAGE` accepts every type."""
        self._check_open()
        return await self._endpoints.subscribe(self.resolve(topic), message_type, on_messages, **options)

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ServiceServer:
        """Offer a service. A handler that raises RostetherError fails the call with that error's text."""
        self._check_open()
        return await self._endpoints.advertise_service(self.resolve(service), service_type, handler)

    def service_client(
        self, service: str, service_type: ServiceType, *, persistent: bool = False
    ) -> ServiceClient:
        """Return a client for many calls; a persistent one keeps its connection. Close it at the end.

        Raises InvalidNameError.
        """
        return ServiceClient(
            self.resolve(service), service_type, self._master, persistent=persistent, limits=self._limits
        )

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        InvalidNameError.
        """
        self._check_open()
        return await self.service_client(service, service_type).call(request, timeout_s=timeout_s)

    async def get_param(self, name: str) -> ParamValue:
        """Return a parameter's value. Raises UnknownNameError."""
        return await self._master.get_param(self.resolve(name))

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter; a mapping replaces the whole tree below it."""
        resolved = self.resolve(name)
        await self._master.set_param(resolved, value)
        self._endpoints.watches.changed_by_us(resolved)

    async def delete_param(self, name: str) -> None:
        """Delete a parameter. Raises UnknownNameError."""
        resolved = self.resolve(name)
        await self._master.delete_param(resolved)
        self._endpoints.watches.changed_by_us(resolved)

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set."""
        return await self._master.has_param(self.resolve(name))

    async def search_param(self, name: str) -> str | None:
        """Find the nearest parameter of that name, upward from the node itself."""
        if name.startswith("~"):
            return self.resolve(name) if await self.has_param(name) else None
        return await self._master.search_param(name)

    async def list_params(self) -> list[str]:
        """Return the full names of all parameters, sorted."""
        return sorted(await self._master.param_names())

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> ParameterWatch:
        """Call back with the value now and whenever it has changed; None means it is unset."""
        self._check_open()
        return await self._endpoints.watches.add(self.resolve(name), on_change)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self._rosout.log(level, text)

    @property
    def is_time_simulated(self) -> bool:
        """Whether ROS time comes from /clock."""
        return self._clock.is_simulated

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return self._clock.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph. Raises MasterUnreachableError."""
        return await self._snapshots.take()

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change, within about a second of it."""
        return watch_changes(self._master, self._closed)

    async def _open(self, check_interval_s: float) -> None:
        await self._endpoints.open()
        is_simulated = await self._is_time_simulated()
        await self._endpoints.add_publication(self._rosout.publication)
        if is_simulated:
            self._clock.simulate()
            await self._endpoints.subscribe(CLOCK_TOPIC, CLOCK_TYPE, self._clock.handle_messages)
        self._endpoints.start_watch(check_interval_s)

    async def _is_time_simulated(self) -> bool:
        try:
            return bool(await self._master.get_param(USE_SIM_TIME))
        except UnknownNameError:
            return False

    def _report(self, level: Level, text: str) -> None:
        _log.log(level.number_in_tens, "%s: %s", self.node_name, text)
        self.log(level, text)

    def _leave(self, reason: str) -> None:
        if self._closing is None:
            self._report(Level.WARN, f"leaving the graph: {reason}")
            if self._on_leave is not None:
                self._on_leave(reason)
            else:
                self._start_close(reason)

    async def _end(self) -> None:
        await self._endpoints.close()
        await self._master.close()


class RosoutLog:
    """Publishes logs; latched as in roscpp and rospy, so that later subscribers get the last one."""

    def __init__(
        self, node_name: str, *, now: Callable[[], Time], published_topics: Callable[[], Iterable[str]]
    ) -> None:
        # Problems of the log topic cannot be logged on it.
        self.publication = Publication(
            ROSOUT, LOG_TYPE, node_name=node_name, report=lambda _level, _text: None, latch=True
        )
        self._node_name = node_name
        self._now = now
        self._published_topics = published_topics
        self._sequence = 0

    def log(self, level: Level, text: str) -> None:
        """Publish one message."""
        self._sequence += 1
        message = encode_log(
            sequence=self._sequence,
            stamp=self._now(),
            level=level,
            node_name=self._node_name,
            text=text,
            topics=self._published_topics(),
        )
        self.publication.publish([message])

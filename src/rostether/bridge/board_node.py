"""A board in the graph: its node, its endpoints and its log lines. It is kept between connections."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from msgspec.structs import replace

from rostether.bridge.endpoint.factory import EndpointFactory
from rostether.bridge.endpoint.publisher import PublisherEndpoint
from rostether.bridge.endpoint.table import EndpointTable
from rostether.bridge.findings.board_health import BoardHealth
from rostether.bridge.findings.required import RequiredTopics
from rostether.bridge.reporter import Notices, Reporter
from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.errors import RostetherError
from rostether.graph.ports import Graph, Level
from rostether.mechanisms.rate_limits import TokenBucket
from rostether.ports.settings import NO_SETTINGS, DeviceSettings
from rostether.rosserial.events import (
    AnnouncementRefused,
    ServiceAnnounced,
    ServiceRole,
    TopicAnnounced,
    TopicRole,
)
from rostether.rosserial.host_link import HostLinkConfig
from rostether.rosserial.packets import TopicInfo
from rostether.serde.store import TypeStore
from rostether.transports.address import ProgramSize

# Lines reported at once: twice those of the largest board, which has 256 endpoints, and some reserve.
SAVED_LINES = 600
# After that limit, one line per this many seconds.
LINE_PERIOD_S = 5.0
# After lines were omitted, reporting starts again when this many lines are allowed: enough for all topics of
# a usual board.
RESUME_LINES = 60
# How often the number of omitted lines is reported.
SUMMARY_PERIOD_S = 60.0
# A graph does not report that a subscriber has connected.
_SUBSCRIBER_POLL_S = 0.005


class BoardNode:
    """One board's node in the graph."""

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        reporter: Reporter,
        clock: Callable[[], float],
        settings: BridgeSettings = DEFAULT_SETTINGS,
        device: DeviceSettings = NO_SETTINGS,
    ) -> None:
        self.graph = graph
        self.settings = replace(settings, **device.limits)
        self.device = device
        self.notices = Notices(reporter, graph.node_name, clock)
        self.notices.to_graph = graph.log
        self.setup = SetupLines(self.notices, clock)
        self.endpoints = EndpointTable(
            EndpointFactory(graph, store, self.notices, self.settings, device, clock), self.notices
        )
        self.health = BoardHealth(
            self.endpoints, store, self.notices, RequiredTopics(device.required_topics, graph.resolve)
        )
        self.store = store

        # For diagnostics: a serial number or address, the same each time the board connects.
        self.hardware_id = ""
        # None if the bridge does not know the board's program.
        self.program: ProgramSize | None = None

    def link_config(self) -> HostLinkConfig:
        """Return the configuration of a link to the board."""
        return HostLinkConfig(
            max_payload_bytes=self.settings.frame_bytes,
            max_endpoints=self.settings.endpoints,
            fixed_size=self._fixed_size,
            name=self.graph.node_name,
        )

    def _fixed_size(self, info: TopicInfo) -> int | None:
        """Return the size of every message of a topic, None if they differ or its type is not known yet."""
        registry = self.store.registry
        if not registry.can_answer(lambda: registry.message_type(info.message_type)):
            return None
        try:
            return self.store.layout(info.message_type).fixed_size_bytes
        except RostetherError:
            return None

    async def wait_for_subscribers(self) -> None:
        """Wait until each topic of the board that nodes subscribe to has a connected subscriber."""
        topics = (await self.graph.snapshot()).topics
        for _, endpoint in tuple(self.endpoints):
            if isinstance(endpoint, PublisherEndpoint):
                entry = topics.get(self.graph.resolve(endpoint.info.topic_name))
                while entry is not None and entry.subscribers and not endpoint.has_subscribers:  # noqa: ASYNC110
                    await asyncio.sleep(_SUBSCRIBER_POLL_S)

    async def close(self) -> None:
        """Leave the graph with all endpoints. Idempotent."""
        self.notices.to_graph = None
        await self.endpoints.close()
        await self.graph.close()


class SetupLines:
    """Reports the topics and services of one board, over all its connections, at a limited rate."""

    def __init__(self, notices: Notices, clock: Callable[[], float]) -> None:
        self._notices = notices
        self._clock = clock
        self._noted_sizes: set[TopicRole] = set()
        self._lines = TokenBucket(1 / LINE_PERIOD_S, SAVED_LINES, clock())
        self._left_out = 0
        self._summed_s = float("-inf")

    def connected(self) -> None:
        """Record that a connection begins."""
        self._noted_sizes.clear()

    def note_size(self, event: TopicAnnounced) -> None:
        """Report the size of the board's buffer, once for each direction."""
        if event.role in self._noted_sizes:
            return
        self._noted_sizes.add(event.role)
        what = "publish" if event.role is TopicRole.PUBLISHER else "subscribe"
        self._report(f"Note: {what} buffer size is {event.info.buffer_size} bytes")

    def report_topic(self, event: TopicAnnounced) -> None:
        """Report that a topic is served."""
        self._report(f"Setup {event.role.value} on {event.info.topic_name} [{event.info.message_type}]")

    def report_service(self, event: ServiceAnnounced) -> None:
        """Report that a service is served."""
        what = "server" if event.role is ServiceRole.SERVER else "client"
        self._report(f"Setup service {what} on {event.name} [{event.type}]")

    def report_refusal(self, event: AnnouncementRefused) -> None:
        """Report why a topic is not served."""
        name = event.topic_name or "a topic without a name"
        self._report(f"{name} [{event.message_type}] is not bridged: {event.reason}", Level.ERROR)

    def _report(self, text: str, level: Level = Level.INFO) -> None:
        now_s = self._clock()
        if self._lines.room(now_s) < (RESUME_LINES if self._left_out else 1):
            self._leave_out(now_s)
            return
        self._lines.admit(1, now_s)
        self._left_out = 0
        self._notices.report(level, text)

    def _leave_out(self, now_s: float) -> None:
        self._left_out += 1
        if now_s - self._summed_s >= SUMMARY_PERIOD_S:
            self._summed_s = now_s
            self._notices.report(
                Level.WARN,
                f"the board announces its topics repeatedly; these lines are omitted ({self._left_out}"
                " so far); check its power and cable, and that no other board has the same name",
            )

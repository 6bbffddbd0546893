"""A board in the graph: its node, its endpoints and its log lines. It outlives connections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rostether.bridge.endpoint.factory import EndpointFactory
from rostether.bridge.endpoint.table import EndpointTable
from rostether.bridge.findings.board_health import BoardHealth
from rostether.bridge.findings.required import RequiredTopics
from rostether.bridge.reporter import Notices, Reporter
from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.bridge.setup_lines import SetupLines
from rostether.errors import RostetherError
from rostether.graph.ports import Graph
from rostether.ports.settings import NO_SETTINGS, DeviceSettings
from rostether.rosserial.host_link_config import HostLinkConfig
from rostether.rosserial.packets import TopicInfo
from rostether.serde.store import TypeStore
from rostether.transports.address import ProgramSize


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
        # None if the bridge does not know what the board runs.
        self.program: ProgramSize | None = None

    def link_config(self) -> HostLinkConfig:
        """Return the limits of a connection to the board."""
        return HostLinkConfig(
            max_payload_bytes=self.settings.frame_bytes,
            max_endpoints=self.settings.endpoints,
            fixed_size=self._fixed_size,
            name=self.graph.node_name,
        )

    def _fixed_size(self, info: TopicInfo) -> int | None:
        """Return the size of every message of a topic, None if they differ or its type is not known yet."""
        registry = self.store.registry
        if not registry.is_at_hand(lambda: registry.message_type(info.message_type)):
            return None
        try:
            return self.store.layout(info.message_type).fixed_size_bytes
        except RostetherError:
            return None

    async def close(self) -> None:
        """Leave the graph with all endpoints. Idempotent."""
        self.notices.to_graph = None
        await self.endpoints.close()
        await self.graph.close()

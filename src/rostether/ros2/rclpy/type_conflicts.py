"""Reports endpoints of other nodes that use a topic with another type: neither DDS nor rclpy reports them."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rostether.graph.ports import Level
from rostether.ros2.endpoint_info import EndpointKind, different_type_text
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.view import node_name_of

# How often types are compared; users do not notice 2 s, and the checks of a hundred boards need 3 % of a CPU.
CHECK_INTERVAL_S = 2.0


class TypeConflicts:
    """Reports each conflict of one node once, and again if it ends and returns."""

    def __init__(self, own: OwnNode) -> None:
        self._own = own
        self._reported: set[str] = set()

    def report(self, used: Mapping[EndpointKind, Collection[tuple[str, str]]]) -> None:
        """Report the conflicts of this node's topics; call it in the executor's thread.

        `used` has, for each kind of this node's endpoints, their topics and types.
        """
        types = dict(self._own.node.get_topic_names_and_types())
        found: set[str] = set()
        for kind, topics in used.items():
            for topic, own_type in topics:
                if len(types.get(topic, ())) > 1:
                    found.update(self._explain(kind, topic, own_type))
        for text in sorted(found - self._reported):
            self._own.report_from_thread(Level.WARN, text)
        self._reported = found

    def _explain(self, kind: EndpointKind, topic: str, own_type: str) -> list[str]:
        node = self._own.node
        if kind is EndpointKind.PUBLISHER:
            other_kind, others = EndpointKind.SUBSCRIPTION, node.get_subscriptions_info_by_topic(topic)
        else:
            other_kind, others = EndpointKind.PUBLISHER, node.get_publishers_info_by_topic(topic)
        return [
            different_type_text(name, other_kind, topic, other.topic_type, own_type)
            for other in others
            if other.topic_type != own_type and (name := node_name_of(other))
        ]

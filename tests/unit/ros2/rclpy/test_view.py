"""The whole graph from the answers of rclpy about each node."""

from __future__ import annotations

from rostether.ros2.rclpy.view import offered_types, take_snapshot

Endpoints = list[tuple[str, list[str]]]


class FakeNode:
    """Answers like rclpy's node about two nodes, and one that has just left."""

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [
            ("b", "/ns"),
            ("a", "/"),
            ("a", "/"),
            ("gone", "/"),
            ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_"),
        ]

    def _of(self, name: str, table: dict[str, Endpoints]) -> Endpoints:
        if name == "gone":
            raise RuntimeError("cannot get names: node does not exist")
        return table[name]

    def get_publisher_names_and_types_by_node(self, name: str, namespace: str) -> Endpoints:
        return self._of(name, {"a": [("/chat", ["p/msg/B"])], "b": [("/chat", ["p/msg/A"])]})

    def get_subscriber_names_and_types_by_node(self, name: str, namespace: str) -> Endpoints:
        return self._of(name, {"a": [], "b": [("/able", ["p/msg/A"])]})

    def get_service_names_and_types_by_node(self, name: str, namespace: str) -> Endpoints:
        return self._of(name, {"a": [("/do", ["p/srv/A"])], "b": []})


def test_a_snapshot() -> None:
    snapshot = take_snapshot(FakeNode())
    assert snapshot.nodes == ("/a", "/gone", "/ns/b")
    assert list(snapshot.topics) == ["/able", "/chat"]
    chat = snapshot.topics["/chat"]
    assert (chat.type, chat.publishers, chat.subscribers) == ("p/msg/A p/msg/B", ("/a", "/ns/b"), ())
    assert snapshot.topics["/able"].subscribers == ("/ns/b",)
    assert snapshot.services["/do"].providers == ("/a",)


def test_the_types_of_a_service() -> None:
    assert offered_types(FakeNode(), "/do") == ["p/srv/A"]
    assert offered_types(FakeNode(), "/undo") == []

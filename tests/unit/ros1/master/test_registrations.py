"""The Master's tables."""

from __future__ import annotations

import pytest

from rostether.errors import GraphError
from rostether.ros1.master import registrations as module
from rostether.ros1.master.registrations import EntryKind, Registrations


def test_a_node_is_known_while_it_has_registrations() -> None:
    tables = Registrations()
    tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    tables.register(EntryKind.SUBSCRIBER, "/t", "/a", "http://a/")
    assert tables.nodes["/a"].api == "http://a/"
    assert tables.unregister(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    assert "/a" in tables.nodes
    assert tables.unregister(EntryKind.SUBSCRIBER, "/t", "/a", "http://a/")
    assert tables.nodes == {}
    assert tables.keys(EntryKind.PUBLISHER) == tables.keys(EntryKind.SUBSCRIBER) == []


def test_registering_twice_is_registering_once() -> None:
    tables = Registrations()
    for _ in range(2):
        tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    assert list(tables.state(EntryKind.PUBLISHER)) == [["/t", ["/a"]]]
    assert tables.unregister(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    assert not tables.unregister(EntryKind.PUBLISHER, "/t", "/a", "http://a/")


def test_members_are_in_the_order_of_registration() -> None:
    tables = Registrations()
    for name in ("/c", "/a", "/b"):
        tables.register(EntryKind.SUBSCRIBER, "/t", name, f"http:/{name}/")
    assert tables.apis(EntryKind.SUBSCRIBER, "/t") == ["http://c/", "http://a/", "http://b/"]
    assert tables.apis(EntryKind.SUBSCRIBER, "/none") == []


@pytest.mark.parametrize("api", ["http://other/", ""])
def test_only_the_registered_uri_unregisters(api: str) -> None:
    tables = Registrations()
    tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    assert not tables.unregister(EntryKind.PUBLISHER, "/t", "/a", api)
    assert tables.apis(EntryKind.PUBLISHER, "/t") == ["http://a/"]


def test_a_new_uri_replaces_the_node_with_all_its_registrations() -> None:
    tables = Registrations()
    tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://old/")
    tables.register(EntryKind.SUBSCRIBER, "/u", "/a", "http://old/")
    tables.register(EntryKind.PARAM, "/p/", "/a", "http://old/")
    tables.register_service("/s", "/a", "http://old/", "rosrpc://old")
    replaced = tables.register(EntryKind.SUBSCRIBER, "/v", "/a", "http://new/")
    assert replaced is not None
    assert (replaced.name, replaced.api, replaced.topics) == ("/a", "http://old/", ("/t",))
    assert tables.nodes["/a"].api == "http://new/"
    assert tables.service_api("/s") is None
    assert [tables.keys(kind) for kind in EntryKind] == [[], ["/v"], [], []]


def test_a_service_has_one_provider() -> None:
    tables = Registrations()
    tables.register_service("/s", "/a", "http://a/", "rosrpc://a")
    tables.register_service("/s", "/b", "http://b/", "rosrpc://b")
    assert list(tables.state(EntryKind.SERVICE)) == [["/s", ["/b"]]]
    assert tables.service_api("/s") == "rosrpc://b"
    assert not tables.unregister_service("/s", "/a", "rosrpc://a"), "it is b's now"
    assert tables.service_api("/s") == "rosrpc://b"
    assert "/a" not in tables.nodes, "nothing is left of a"
    assert not tables.unregister_service("/s", "/b", "rosrpc://a")
    assert tables.unregister_service("/s", "/b", "rosrpc://b")
    assert tables.service_api("/s") is None
    assert tables.nodes == {}


def test_a_node_that_lost_its_service_can_still_be_looked_up() -> None:
    tables = Registrations()
    tables.register_service("/s", "/a", "http://a/", "rosrpc://a")
    tables.register_service("/s", "/b", "http://b/", "rosrpc://b")
    assert tables.nodes["/a"].api == "http://a/"
    assert tables.drop("/a").topics == ()
    assert tables.service_api("/s") == "rosrpc://b"


def test_dropping_removes_everything() -> None:
    tables = Registrations()
    tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    tables.register(EntryKind.PUBLISHER, "/u", "/a", "http://a/")
    tables.register(EntryKind.PUBLISHER, "/t", "/b", "http://b/")
    tables.register_service("/s", "/a", "http://a/", "rosrpc://a")
    assert tables.drop("/a").topics == ("/t", "/u")
    assert list(tables.state(EntryKind.PUBLISHER)) == [["/t", ["/b"]]]
    assert tables.keys(EntryKind.SERVICE) == []
    assert list(tables.nodes) == ["/b"]


@pytest.mark.parametrize(
    ("learned", "known"),
    [
        ([("*", True)], "*"),
        ([("*", False)], None),
        ([("a/A", False)], "a/A"),
        ([("a/A", True), ("b/B", True)], "b/B"),
        ([("a/A", True), ("b/B", False)], "a/A"),
        ([("a/A", False), ("b/B", True)], "b/B"),
        ([("a/A", True), ("*", True)], "a/A"),
        ([("*", True), ("a/A", False)], "*"),
    ],
)
def test_the_type_of_a_publisher_wins(learned: list[tuple[str, bool]], known: str | None) -> None:
    tables = Registrations()
    for name, from_publisher in learned:
        tables.learn_type("/t", name, from_publisher=from_publisher)
    assert tables.topic_types.get("/t") == known


def test_types_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_TOPIC_TYPES", 3)
    tables = Registrations()
    tables.register(EntryKind.PUBLISHER, "/0", "/a", "http://a/")
    for number in range(5):
        tables.learn_type(f"/{number}", "a/A", from_publisher=True)
    assert list(tables.topic_types) == ["/0", "/3", "/4"], "those still published stay"


def test_registrations_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_REGISTRATIONS", 2)
    tables = Registrations()
    tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    tables.register_service("/s", "/a", "http://a/", "rosrpc://a")
    with pytest.raises(GraphError, match="has 2 registrations, its limit;"):
        tables.register(EntryKind.SUBSCRIBER, "/t", "/b", "http://b/")
    assert "/b" not in tables.nodes
    tables.register(EntryKind.PUBLISHER, "/t", "/a", "http://a/")
    tables.unregister_service("/s", "/a", "rosrpc://a")
    tables.register(EntryKind.SUBSCRIBER, "/t", "/b", "http://b/")

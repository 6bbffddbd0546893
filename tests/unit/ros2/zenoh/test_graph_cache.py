from __future__ import annotations

import asyncio

from rostether.graph.ports import ServiceEntry, TopicEntry
from rostether.ros2.zenoh.graph_cache import GraphCache
from rostether.ros2.zenoh.tokens import Token, TokenKind

HASH = "RIHS01_" + "0" * 64


def token(kind: TokenKind, node: str, name: str = "", type_name: str = "", entity_id: int = 0) -> str:
    return Token(0, "abc", 0, entity_id, kind, "/", node, name, type_name, HASH).format()


STRING = "std_msgs::msg::dds_::String_"
TALKER = token(TokenKind.PUBLISHER, "talker", "/chat", STRING, 1)
LISTENER = token(TokenKind.SUBSCRIBER, "listener", "/chat", STRING, 2)
SERVER = token(TokenKind.SERVER, "server", "/switch", "std_srvs::srv::dds_::SetBool_", 3)
CLIENT = token(TokenKind.CLIENT, "client", "/switch", "std_srvs::srv::dds_::SetBool_", 4)


def test_a_snapshot_matches_the_tokens() -> None:
    graph = GraphCache()
    graph.apply_tokens(
        [(each, True) for each in (TALKER, LISTENER, SERVER, CLIENT, token(TokenKind.NODE, "idle"))]
    )
    snapshot = graph.snapshot()
    assert snapshot.nodes == ("/client", "/idle", "/listener", "/server", "/talker")
    assert snapshot.topics == {
        "/chat": TopicEntry("/chat", "std_msgs/msg/String", ("/talker",), ("/listener",))
    }
    # A client without a server is not a service.
    assert snapshot.services == {"/switch": ServiceEntry("/switch", ("/server",), "std_srvs/srv/SetBool")}
    assert graph.snapshot() is snapshot


def test_removed_entries_are_forgotten() -> None:
    graph = GraphCache()
    graph.apply_tokens([(TALKER, True), (SERVER, True)])
    graph.apply_tokens([(TALKER, True), (TALKER, False), (SERVER, False), (SERVER, False), (CLIENT, False)])
    snapshot = graph.snapshot()
    assert (snapshot.nodes, snapshot.topics, snapshot.services) == ((), {}, {})
    assert graph.endpoints(TokenKind.PUBLISHER, "/chat") == []


def test_a_change_creates_only_the_changed_entries_again() -> None:
    graph = GraphCache()
    graph.apply_tokens(
        [(TALKER, True), (SERVER, True), (token(TokenKind.PUBLISHER, "b", "/other", STRING), True)]
    )
    before = graph.snapshot()
    graph.apply_tokens([(LISTENER, True)])
    after = graph.snapshot()
    assert after.topics["/chat"].subscribers == ("/listener",)
    assert after.topics["/other"] is before.topics["/other"], "fleets have thousands"
    assert after.services["/switch"] is before.services["/switch"]
    graph.apply_tokens([(LISTENER, False), (token(TokenKind.SERVER, "twin", "/switch", entity_id=9), True)])
    last = graph.snapshot()
    assert (last.nodes, last.topics) == (("/b", "/server", "/talker", "/twin"), before.topics)
    assert last.services["/switch"].providers == ("/server", "/twin")


def test_invalid_tokens_are_skipped() -> None:
    graph = GraphCache()
    graph.apply_tokens([("", True), ("@ros2_lv/0/nonsense", True), ("x" * 100_000, True)])
    assert graph.snapshot().nodes == ()


def test_several_types_of_a_topic_are_all_reported() -> None:
    graph = GraphCache()
    graph.apply_tokens(
        [(TALKER, True), (token(TokenKind.SUBSCRIBER, "odd", "/chat", "std_msgs::msg::dds_::Bool_"), True)]
    )
    assert graph.snapshot().topics["/chat"].type == "std_msgs/msg/Bool std_msgs/msg/String"


def test_listeners_are_called_for_their_endpoints_once_per_batch() -> None:
    graph = GraphCache()
    received: list[int] = []

    def listen() -> None:
        received.append(len(graph.endpoints(TokenKind.PUBLISHER, "/chat")))

    graph.listen(TokenKind.PUBLISHER, "/chat", listen)
    graph.apply_tokens([(TALKER, True), (token(TokenKind.PUBLISHER, "other", "/chat", STRING), True)])
    graph.apply_tokens([(LISTENER, True)])
    graph.apply_tokens([(TALKER, False)])
    graph.unlisten(TokenKind.PUBLISHER, "/chat", listen)
    graph.unlisten(TokenKind.PUBLISHER, "/chat", listen)
    graph.apply_tokens([(TALKER, True)])
    assert received == [2, 1]


async def test_changes_end_when_the_node_does() -> None:
    graph, closed = GraphCache(), asyncio.Event()
    changes = graph.changed.follow(graph.snapshot, closed)
    assert (await anext(changes)).nodes == ()
    graph.apply_tokens([(TALKER, True)])
    assert (await anext(changes)).nodes == ("/talker",)
    waiting = asyncio.ensure_future(anext(changes, None))
    closed.set()
    assert await waiting is None

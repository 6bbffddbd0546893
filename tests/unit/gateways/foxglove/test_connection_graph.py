from __future__ import annotations

from rostether.gateways.foxglove.connection_graph import ConnectionGraph
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.msgdef.registry import Registry


def snapshot(
    topics: dict[str, tuple[tuple[str, ...], tuple[str, ...]]], services: dict[str, tuple[str, ...]]
) -> Snapshot:
    return Snapshot(
        (),
        {name: TopicEntry(name, "a/B", *sides) for name, sides in topics.items()},
        {name: ServiceEntry(name, providers) for name, providers in services.items()},
    )


def test_changes_bring_who_knows_the_rest_to_the_whole() -> None:
    graph = ConnectionGraph(lambda name: None)
    first = graph.update(snapshot({"/a": (("/n",), ("/m",)), "/b": (("/n",), ())}, {"/s": ("/n",)}))
    assert first == graph.whole()
    assert graph.update(snapshot({"/a": (("/n",), ("/m",)), "/b": (("/n",), ())}, {"/s": ("/n",)})) is None
    changes = graph.update(snapshot({"/a": ((), ("/m",))}, {}))
    assert changes == {
        "publishedTopics": [{"name": "/a", "publisherIds": []}],
        "subscribedTopics": [{"name": "/a", "subscriberIds": ["/m"]}],
        "advertisedServices": [],
        "removedTopics": ["/b"],
        "removedServices": ["/s"],
    }
    assert graph.whole()["publishedTopics"] == []


def test_a_topic_without_publisher_brings_its_type() -> None:
    boolean = Registry().message_type("std_msgs/Bool")
    graph = ConnectionGraph(lambda name: boolean if name == "a/B" else None)
    entry = {"name": "/led", "subscriberIds": ["/board"]}
    schema = {"schemaName": "std_msgs/Bool", "schema": boolean.definition}
    first = graph.update(snapshot({"/led": ((), ("/board",))}, {}))
    assert first is not None
    assert first["subscribedTopics"] == [entry | schema]
    assert graph.whole() == first
    published = graph.update(snapshot({"/led": (("/page",), ("/board",))}, {}))
    assert published is not None
    assert published["subscribedTopics"] == [entry]
    assert graph.whole()["subscribedTopics"] == [entry]
    ended = graph.update(snapshot({"/led": ((), ("/board",))}, {}))
    assert ended is not None
    assert ended["subscribedTopics"] == [entry | schema]

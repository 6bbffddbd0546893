from __future__ import annotations

from rostether.gateways.foxglove.connection_graph import ConnectionGraph
from rostether.graph.ports import ServiceInfo, Snapshot, TopicInfo


def snapshot(
    topics: dict[str, tuple[tuple[str, ...], tuple[str, ...]]], services: dict[str, tuple[str, ...]]
) -> Snapshot:
    return Snapshot(
        (),
        {name: TopicInfo(name, "a/B", *sides) for name, sides in topics.items()},
        {name: ServiceInfo(name, providers) for name, providers in services.items()},
    )


def test_changes_bring_who_knows_the_rest_to_the_whole() -> None:
    graph = ConnectionGraph()
    first = graph.update(snapshot({"/a": (("/n",), ("/m",)), "/b": (("/n",), ())}, {"/s": ("/n",)}))
    assert first == graph.whole()
    assert graph.update(snapshot({"/a": (("/n",), ("/m",)), "/b": (("/n",), ())}, {"/s": ("/n",)})) is None
    changes = graph.update(snapshot({"/a": ((), ("/m",))}, {}))
    assert changes == {
        "publishedTopics": [{"name": "/a", "publisherIds": []}],
        "subscribedTopics": [],
        "advertisedServices": [],
        "removedTopics": ["/b"],
        "removedServices": ["/s"],
    }
    assert graph.whole()["publishedTopics"] == []

"""Parameters."""

from __future__ import annotations

import pytest

from contract.capabilities import Capabilities
from contract.graphs import wait_for_nodes
from rostether.errors import RostetherError, UnknownNameError
from rostether.graph.ports import JoinGraph, ParamValue
from waiting import until

VALUES: list[ParamValue] = [
    True,
    -7,
    2.5,
    "text <&> ä",
    "",
    b"\x00\xff",
    [True, False],
    [1, -2, 3],
    [0.5, 1.0],
    ["one", ""],
    {"p": 1, "d": {"i": 0.5}},
    [],
]
MIXED: ParamValue = [1, 2.5, "three", [True]]


@pytest.mark.parametrize("value", VALUES)
async def test_values_are_read_as_they_were_set(join: JoinGraph, value: ParamValue) -> None:
    one, other = await join("/one"), await join("/other")
    await wait_for_nodes(one, other)
    await one.set_param("/one/gains/arm", value)
    for node in (one, other):
        received = await node.get_param("/one/gains/arm")
        assert received == value
        assert type(received) is type(value)


async def test_lists_of_different_types(join: JoinGraph, capabilities: Capabilities) -> None:
    node = await join("/node")
    if capabilities.mixed_lists:
        await node.set_param("~list", MIXED)
        assert await node.get_param("~list") == MIXED
    else:
        with pytest.raises(RostetherError, match="list of one type") as caught:
            await node.set_param("~list", MIXED)
        assert "\n" not in str(caught.value)
        assert not await node.has_param("~list")


async def test_nodes_set_each_others_parameters(join: JoinGraph) -> None:
    one, other = await join("/one"), await join("/other")
    await wait_for_nodes(one, other)
    await other.set_param("/one/gains/p", 1.5)
    assert await one.get_param("~gains/p") == 1.5
    assert await other.has_param("/one/gains/p")
    assert "/one/gains/p" in await other.list_params()
    await other.delete_param("/one/gains/p")
    assert not await one.has_param("~gains/p")


async def test_trees_of_a_node(join: JoinGraph) -> None:
    node = await join("/node")
    await node.set_param("/node/robot/arm/p", 1)
    await node.set_param("/node/robot", {"arm": {"i": 2}, "name": "r2"})
    assert await node.get_param("/node/robot") == {"arm": {"i": 2}, "name": "r2"}
    assert await node.get_param("/node/robot/arm/i") == 2
    assert not await node.has_param("/node/robot/arm/p")
    assert await node.has_param("/node/robot/arm")
    names = await node.list_params()
    below = [name for name in names if name.startswith("/node/robot")]
    assert below == ["/node/robot/arm/i", "/node/robot/name"]
    assert names == sorted(names)
    await node.delete_param("/node/robot/arm")
    assert await node.get_param("/node/robot") == {"name": "r2"}


async def test_trees_of_other_nodes(join: JoinGraph) -> None:
    node, other = await join("/node"), await join("/other")
    await wait_for_nodes(node, other)
    await other.set_param("/node/robot", {"arm": {"p": 1}})
    await other.set_param("/node/robot", {"arm": {"i": 2}, "name": "r2"})
    for each in (node, other):
        assert await each.get_param("/node/robot") == {"arm": {"i": 2}, "name": "r2"}
    await other.delete_param("/node/robot/arm")
    assert await node.get_param("~robot") == {"name": "r2"}


async def test_a_parameter_that_is_not_set_is_an_error(join: JoinGraph) -> None:
    node, other = await join("/node"), await join("/other")
    await wait_for_nodes(node, other)
    for name in ("/nothing", "/node/nothing", "/other/nothing"):
        with pytest.raises(UnknownNameError, match=name):
            await node.get_param(name)
        with pytest.raises(UnknownNameError, match=name):
            await node.delete_param(name)
        assert not await node.has_param(name)


async def test_names_are_resolved(join: JoinGraph) -> None:
    node = await join("board", namespace="/robot", remappings={"baud": "speed"})
    await node.set_param("~port", "/dev/ttyACM0")
    await node.set_param("baud", 57600)
    assert await node.get_param("/robot/board/port") == "/dev/ttyACM0"
    assert await node.get_param("/robot/speed") == 57600


async def test_a_name_below_no_node_belongs_to_the_node_that_sets_it(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    node, other = await join("/lab/robot"), await join("/other")
    await wait_for_nodes(node, other)
    await node.set_param("/gains/p", 1)
    assert await node.get_param("/gains/p") == 1
    assert await other.has_param("/gains/p") is capabilities.global_parameters
    assert await node.has_param("~gains/p") is not capabilities.global_parameters


async def test_search_checks_namespaces_from_the_node_upwards(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    capabilities.require("global_parameters")
    node = await join("board", namespace="/lab/robot")
    assert await node.search_param("rate") is None
    for name in ("/rate", "/lab/rate", "/lab/robot/rate", "/lab/robot/board/rate"):
        await node.set_param(name, 1)
        assert await node.search_param("rate") == name
    await node.set_param("/gains/p", 1)
    # Only the first part of the name must exist.
    assert await node.search_param("gains/i") == "/gains/i"
    assert await node.search_param("/gains/p") == "/gains/p"
    assert await node.search_param("/gains/i") is None


async def test_search_finds_private_parameters(join: JoinGraph) -> None:
    node = await join("board", namespace="/lab/robot")
    assert await node.search_param("rate") is None
    assert await node.search_param("~rate") is None
    await node.set_param("~rate", 1)
    for name in ("rate", "~rate", "/lab/robot/board/rate"):
        assert await node.search_param(name) == "/lab/robot/board/rate"


@pytest.mark.parametrize("owner", ["watcher", "other"])
async def test_a_watch_reports_the_value_now_and_every_change(join: JoinGraph, owner: str) -> None:
    watcher, other = await join("/watcher"), await join("/other")
    await wait_for_nodes(watcher, other)
    name = f"/{owner}/rate"
    await other.set_param(name, 1)
    seen: list[ParamValue] = []
    watch = await watcher.watch_param(name, seen.append)
    await until(lambda: seen == [1])
    await other.set_param(name, 2)
    await until(lambda: seen == [1, 2])
    await other.delete_param(name)
    await until(lambda: seen == [1, 2, None])
    await watcher.set_param(name, 3)
    await until(lambda: seen == [1, 2, None, 3])
    await watch.close()
    await watch.close()
    again: list[ParamValue] = []
    await watcher.watch_param(name, again.append)
    await other.set_param(name, 4)
    await until(lambda: again == [3, 4])
    assert seen == [1, 2, None, 3]


async def test_a_watch_reports_changes_above_and_below(join: JoinGraph) -> None:
    watcher, other = await join("/watcher"), await join("/other")
    await wait_for_nodes(watcher, other)
    leaf: list[ParamValue] = []
    tree: list[ParamValue] = []
    await watcher.watch_param("/watcher/arm/gains/p", leaf.append)
    await watcher.watch_param("/watcher/arm", tree.append)
    await until(lambda: leaf == tree == [None])
    await other.set_param("/watcher/arm", {"gains": {"p": 1}})
    await until(lambda: leaf[1:] == [1] and tree[1:] == [{"gains": {"p": 1}}])
    await other.set_param("/watcher/arm/gains/p", 2)
    await until(lambda: leaf[-1] == 2 and tree[-1] == {"gains": {"p": 2}})
    await other.delete_param("/watcher/arm")
    await until(lambda: leaf[-1] is None and tree[-1] is None)


async def test_two_watches_of_one_name_are_independent(join: JoinGraph) -> None:
    node = await join("/node")
    first: list[ParamValue] = []
    second: list[ParamValue] = []
    watch = await node.watch_param("~rate", first.append)
    await node.watch_param("~rate", second.append)
    await watch.close()
    await node.set_param("~rate", 5)
    await until(lambda: second == [None, 5])
    assert first == [None]


async def test_a_watch_works_after_an_error_of_its_callback(
    join: JoinGraph, caplog: pytest.LogCaptureFixture
) -> None:
    node = await join("/node")
    seen: list[ParamValue] = []

    def fail(value: ParamValue) -> None:
        seen.append(value)
        raise ZeroDivisionError("a user's mistake")

    await node.watch_param("~rate", fail)
    await node.set_param("~rate", 5)
    await until(lambda: seen == [None, 5])
    assert "on_change of parameter /node/rate failed: ZeroDivisionError" in caplog.text

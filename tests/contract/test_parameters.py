"""Parameters."""

from __future__ import annotations

import pytest

from contract.graphs import until
from rostether.errors import UnknownNameError
from rostether.graph.ports import JoinGraph, ParamValue

VALUES: list[ParamValue] = [
    True,
    -7,
    2.5,
    "text <&> ä",
    "",
    b"\x00\xff",
    [1, 2.5, "three", [True]],
    {"p": 1, "d": {"i": 0.5}},
    [],
]


@pytest.mark.parametrize("value", VALUES)
async def test_values_come_back_as_they_were_set(join: JoinGraph, value: ParamValue) -> None:
    one, other = await join("/one"), await join("/other")
    await one.set_param("/gains/arm", value)
    received = await other.get_param("/gains/arm")
    assert received == value
    assert type(received) is type(value)


async def test_trees(join: JoinGraph) -> None:
    node = await join("/node")
    await node.set_param("/robot/arm/p", 1)
    await node.set_param("/robot", {"arm": {"i": 2}, "name": "r2"})
    assert await node.get_param("/robot") == {"arm": {"i": 2}, "name": "r2"}
    assert await node.get_param("/robot/arm/i") == 2
    assert not await node.has_param("/robot/arm/p")
    assert await node.has_param("/robot/arm")
    names = await node.list_params()
    assert [name for name in names if name.startswith("/robot")] == ["/robot/arm/i", "/robot/name"]
    assert names == sorted(names)
    await node.delete_param("/robot/arm")
    assert await node.get_param("/robot") == {"name": "r2"}


async def test_what_is_not_set_is_an_error(join: JoinGraph) -> None:
    node = await join("/node")
    with pytest.raises(UnknownNameError, match="/nothing"):
        await node.get_param("/nothing")
    with pytest.raises(UnknownNameError, match="/nothing"):
        await node.delete_param("/nothing")
    assert not await node.has_param("/nothing")


async def test_names_are_resolved(join: JoinGraph) -> None:
    node = await join("board", namespace="/robot", remappings={"baud": "speed"})
    await node.set_param("~port", "/dev/ttyACM0")
    await node.set_param("baud", 57600)
    assert await node.get_param("/robot/board/port") == "/dev/ttyACM0"
    assert await node.get_param("/robot/speed") == 57600


async def test_search_goes_upward_from_the_node(join: JoinGraph) -> None:
    node = await join("board", namespace="/lab/robot")
    assert await node.search_param("rate") is None
    for name in ("/rate", "/lab/rate", "/lab/robot/rate", "/lab/robot/board/rate"):
        await node.set_param(name, 1)
        assert await node.search_param("rate") == name
    await node.set_param("/gains/p", 1)
    # Only the first part must be there.
    assert await node.search_param("gains/i") == "/gains/i"
    assert await node.search_param("/gains/p") == "/gains/p"
    assert await node.search_param("/gains/i") is None


async def test_a_watch_tells_the_value_now_and_every_change(join: JoinGraph) -> None:
    watcher, other = await join("/watcher"), await join("/other")
    await other.set_param("/rate", 1)
    seen: list[ParamValue] = []
    watch = await watcher.watch_param("/rate", seen.append)
    await until(lambda: seen == [1])
    await other.set_param("/rate", 2)
    await until(lambda: seen == [1, 2])
    await other.delete_param("/rate")
    await until(lambda: seen == [1, 2, None])
    await watcher.set_param("/rate", 3)
    await until(lambda: seen == [1, 2, None, 3])
    await watch.close()
    await watch.close()
    again: list[ParamValue] = []
    await watcher.watch_param("/rate", again.append)
    await other.set_param("/rate", 4)
    await until(lambda: again == [3, 4])
    assert seen == [1, 2, None, 3]


async def test_a_watch_sees_changes_above_and_below(join: JoinGraph) -> None:
    watcher, other = await join("/watcher"), await join("/other")
    leaf: list[ParamValue] = []
    tree: list[ParamValue] = []
    await watcher.watch_param("/arm/gains/p", leaf.append)
    await watcher.watch_param("/arm", tree.append)
    await until(lambda: leaf == tree == [None])
    await other.set_param("/arm", {"gains": {"p": 1}})
    await until(lambda: leaf[1:] == [1] and tree[1:] == [{"gains": {"p": 1}}])
    await other.set_param("/arm/gains/p", 2)
    await until(lambda: leaf[-1] == 2 and tree[-1] == {"gains": {"p": 2}})
    await other.delete_param("/arm")
    await until(lambda: leaf[-1] is None and tree[-1] is None)


async def test_two_watches_of_one_name_are_independent(join: JoinGraph) -> None:
    node = await join("/node")
    first: list[ParamValue] = []
    second: list[ParamValue] = []
    watch = await node.watch_param("/rate", first.append)
    await node.watch_param("/rate", second.append)
    await watch.close()
    await node.set_param("/rate", 5)
    await until(lambda: second == [None, 5])
    assert first == [None]


async def test_a_callback_that_fails_ends_nothing(join: JoinGraph, caplog: pytest.LogCaptureFixture) -> None:
    node = await join("/node")
    seen: list[ParamValue] = []

    def fail(value: ParamValue) -> None:
        seen.append(value)
        raise ZeroDivisionError("a user's mistake")

    await node.watch_param("/rate", fail)
    await node.set_param("/rate", 5)
    await until(lambda: seen == [None, 5])
    assert "on_change of parameter /rate failed: ZeroDivisionError" in caplog.text

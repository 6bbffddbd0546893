"""Parameters of nodes of other programs, which the contract tests do not test."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest

from rostether.errors import GraphError, ServiceUnavailableError, UnknownNameError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import ParamValue
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.services import PARAMETER_EVENTS, ParameterServices
from rostether.ros2.parameters.store import ParameterStore
from rostether.ros2.parameters.typed_value import typed_value
from rostether.ros2.rcl_interfaces import rcl_interfaces
from waiting import until


async def join_with(network: MemoryNetwork, name: str, store: ParameterStore) -> MemoryGraph:
    graph = await network.join(name)
    await ParameterServices(store, graph).open()
    return graph


async def answer_with(graph: MemoryGraph, verb: str, name: str, response: Mapping[str, Any]) -> None:
    async def handle(_: bytes) -> bytes:
        return rcl_interfaces().codec(f"{name}Response").encode(response)

    await graph.advertise_service(f"{graph.node_name}/{verb}", rcl_interfaces().service(name), handle)


async def test_parameters_are_requested_one_by_one_if_a_node_returns_nothing_for_several() -> None:
    # In rclpy and rclcpp, all values are missing if one declared parameter has no value.
    network = MemoryNetwork()
    picky, me = await network.join("/picky"), await network.join("/me")
    codec = rcl_interfaces().codec

    async def get(payload: bytes) -> bytes:
        names = codec("GetParametersRequest").decode(payload).names
        values = [] if "unset" in names else [typed_value("", len(name)).to_fields() for name in names]
        return codec("GetParametersResponse").encode({"values": values})

    await picky.advertise_service("/picky/get_parameters", rcl_interfaces().service("GetParameters"), get)
    names = ["a", "unset", "b.cc"]
    await answer_with(picky, "list_parameters", "ListParameters", {"result": {"names": names}})
    parameters = GraphParameters(ParameterStore(), me)
    assert await parameters.get("/picky") == {"a": 1, "b": {"cc": 4}}
    assert await parameters.names() == ["/me/use_sim_time", "/picky/a", "/picky/b/cc"]
    assert not await parameters.has("/picky/unset")


@pytest.mark.parametrize(
    ("before", "given", "after"),
    [
        (1.5, 2, 2.0),
        ([1.5], [2], [2.0]),
        ([1.5], [], []),
        ([1], [], []),
        (b"a", [0, 255], b"\x00\xff"),
        (b"a", [256], [256]),
        (1, 2, 2),
        ("a", 2, 2),
        (None, 2, 2),
    ],
)
async def test_whole_numbers_and_empty_lists_get_the_type_of_the_parameter(
    before: ParamValue, given: ParamValue, after: ParamValue
) -> None:
    network, store = MemoryNetwork(), ParameterStore()
    await join_with(network, "/typed", store)
    if before is not None:
        store.apply({"value": typed_value("value", before)})
    await GraphParameters(ParameterStore(), await network.join("/me")).set("/typed/value", given)
    now = store.get("value")
    assert (now.value, type(now.value)) == (after, type(after))
    assert now.type is typed_value("", after or before).type


async def test_refusals_have_the_reason_of_the_node() -> None:
    network = MemoryNetwork()
    fixed, me = await network.join("/fixed"), await network.join("/me")
    refusal = {"results": [{"successful": False, "reason": "read only,\nreally"}]}
    await answer_with(fixed, "set_parameters", "SetParameters", refusal)
    await answer_with(fixed, "list_parameters", "ListParameters", {})
    with pytest.raises(GraphError, match="node /fixed refused to set its parameter gain: read only, really"):
        await GraphParameters(ParameterStore(), me).set("/fixed/gain", 1)


async def test_a_node_without_parameters_is_named_and_skipped_in_lists(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    network = MemoryNetwork()
    _, me = await network.join("/bare"), await network.join("/me")
    hanging = await network.join("/hanging")

    async def hang(_: bytes) -> bytes:
        await asyncio.Event().wait()
        raise AssertionError("unreachable")

    await hanging.advertise_service(
        "/hanging/list_parameters", rcl_interfaces().service("ListParameters"), hang
    )
    parameters = GraphParameters(ParameterStore({"a": 1}), me)
    with pytest.raises(ServiceUnavailableError, match="node /bare does not give access to its parameters"):
        await parameters.get("/bare/gain")
    monkeypatch.setattr("rostether.ros2.parameters.client.CALL_TIMEOUT_S", 0.05)
    assert await parameters.names() == ["/me/a", "/me/use_sim_time"]
    # It hangs until the test releases it.
    await hanging.close()


async def test_names_with_slashes_are_found() -> None:
    network = MemoryNetwork()
    await join_with(network, "/other", ParameterStore({"qos_overrides./tf.depth": 7}))
    parameters = GraphParameters(ParameterStore(), await network.join("/me"))
    assert "/other/qos_overrides/tf/depth" in await parameters.names()
    assert await parameters.get("/other/qos_overrides/tf/depth") == 7
    assert await parameters.get("/other/qos_overrides") == {"tf": {"depth": 7}}


async def test_a_parameter_may_have_others_below_it() -> None:
    network = MemoryNetwork()
    parameters = GraphParameters(ParameterStore({"a": 1, "a.b": 2, "c.d": 3}), await network.join("/me"))
    assert await parameters.get("/me/a") == 1
    assert await parameters.get("/me/a/b") == 2
    assert await parameters.get("/me") == {"a": 1, "c": {"d": 3}, "use_sim_time": False}


async def test_requested_parameters_are_declared() -> None:
    network = MemoryNetwork()
    store = ParameterStore()
    parameters = GraphParameters(store, await network.join("/me"))
    for name in ("/me/gains/p", "/rate", "/me"):
        await parameters.has(name)
    assert store.declared_names() == ["use_sim_time"]
    for name in ("/me/gains/p", "/rate"):
        with pytest.raises(UnknownNameError):
            await parameters.get(name)
    assert store.declared_names() == ["gains.p", "rate", "use_sim_time"]


async def test_a_node_cannot_be_set_to_a_value() -> None:
    network = MemoryNetwork()
    parameters = GraphParameters(ParameterStore(), await network.join("/me"))
    with pytest.raises(GraphError, match="/me is a node;"):
        await parameters.set("/me", 7)


async def test_watches_continue_after_noise_and_after_nodes_have_left() -> None:
    network = MemoryNetwork()
    me, noise = await network.join("/me"), await network.join("/noise")
    store = ParameterStore({"a": 1})
    other = await join_with(network, "/other", store)
    parameters = GraphParameters(ParameterStore(), me)
    seen: list[ParamValue] = []
    await parameters.watch("/other/a", seen.append)
    assert seen == [1]
    publisher = await noise.advertise(PARAMETER_EVENTS, rcl_interfaces().message("ParameterEvent"))
    publisher.publish_raw([b"not an event"])
    store.apply({"a": typed_value("", 2)})
    await until(lambda: seen == [1, 2])
    assert (await me.snapshot()).topics[PARAMETER_EVENTS].subscribers == ("/me",)
    # An event of a node without services changes nothing.
    event = rcl_interfaces().codec("ParameterEvent").encode({"node": "/other"})
    await other.close()
    publisher.publish_raw([event])
    await parameters.close()
    assert (await me.snapshot()).topics[PARAMETER_EVENTS].subscribers == ()
    assert seen == [1, 2]

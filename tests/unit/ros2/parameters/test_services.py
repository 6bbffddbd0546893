"""A node's parameters on the graph: the answers of its services, and its events."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from typing import Any

import pytest
import pytest_asyncio

from contract.graphs import Inbox
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.ros2.parameters.services import PARAMETER_EVENTS, ParameterServices
from rostether.ros2.parameters.store import ParameterStore
from rostether.ros2.parameters.typed_value import NOT_SET, ParameterType, typed_value
from rostether.ros2.rcl_interfaces import rcl_interfaces
from rostether.serde.values import Message
from waiting import until


class Asker:
    """Calls the services of /lab/board."""

    def __init__(self, graph: MemoryGraph, store: ParameterStore, services: ParameterServices) -> None:
        self.graph = graph
        self.store = store
        self.services = services

    async def ask(self, verb: str, name: str, request: Mapping[str, Any]) -> Message:
        interfaces = rcl_interfaces()
        payload = interfaces.codec(f"{name}Request").encode(request)
        answer = await self.graph.call_service(f"/lab/board/{verb}", interfaces.service(name), payload)
        return interfaces.codec(f"{name}Response").decode(answer)


@pytest_asyncio.fixture
async def asker() -> AsyncIterator[Asker]:
    network = MemoryNetwork()
    node, other = await network.join("/lab/board"), await network.join("/other")
    store = ParameterStore({"gains.p": 1.5, "gains.arm.i": [1, 2], "port": "tty"})
    store.declare("asked")
    services = ParameterServices(store, node)
    await services.open()
    yield Asker(other, store, services)
    await node.close()
    await other.close()


async def test_values_and_types_are_returned(asker: Asker) -> None:
    names = ["gains.p", "gains.arm.i", "nothing", "use_sim_time"]
    answer = await asker.ask("get_parameters", "GetParameters", {"names": names})
    assert [each.type for each in answer.values] == [3, 7, 0, 1]
    assert answer.values[0].double_value == 1.5
    assert answer.values[1].integer_array_value == [1, 2]
    answer = await asker.ask("get_parameter_types", "GetParameterTypes", {"names": names})
    assert list(answer.types) == [3, 7, 0, 1]
    answer = await asker.ask("describe_parameters", "DescribeParameters", {"names": ["port"]})
    (descriptor,) = answer.descriptors
    assert (descriptor.name, descriptor.type, descriptor.dynamic_typing) == ("port", 4, True)
    assert not descriptor.read_only


@pytest.mark.parametrize(
    ("prefixes", "depth", "names", "below"),
    [
        ([], 0, ["asked", "gains.arm.i", "gains.p", "port", "use_sim_time"], ["gains.arm", "gains"]),
        ([], 1, ["asked", "port", "use_sim_time"], []),
        ([], 2, ["asked", "gains.p", "port", "use_sim_time"], ["gains"]),
        (["gains"], 0, ["gains.arm.i", "gains.p"], ["gains.arm", "gains"]),
        (["gains"], 1, ["gains.p"], ["gains"]),
        (["gain"], 0, [], []),
        (["port", "gains.arm"], 1, ["gains.arm.i", "port"], ["gains.arm"]),
    ],
)
async def test_lists_have_the_requested_prefixes_and_depth(
    asker: Asker, prefixes: list[str], depth: int, names: list[str], below: list[str]
) -> None:
    answer = await asker.ask("list_parameters", "ListParameters", {"prefixes": prefixes, "depth": depth})
    assert answer.result.names == names
    assert answer.result.prefixes == below


def parameter(name: str, value: Any) -> dict[str, Any]:
    return {"name": name, "value": typed_value(name, value).to_fields()}


async def test_each_parameter_is_set_separately(asker: Asker) -> None:
    request = {"parameters": [parameter("a", 1), parameter("use_sim_time", 7), parameter("port", None)]}
    answer = await asker.ask("set_parameters", "SetParameters", request)
    assert [each.successful for each in answer.results] == [True, False, True]
    assert "use_sim_time must be a bool" in answer.results[1].reason
    assert asker.store.get("a") == typed_value("a", 1)
    assert asker.store.get("port") == NOT_SET


async def test_all_parameters_are_set_or_none(asker: Asker) -> None:
    request = {"parameters": [parameter("a", 1), parameter("use_sim_time", 7)]}
    answer = await asker.ask("set_parameters_atomically", "SetParametersAtomically", request)
    assert not answer.result.successful
    assert asker.store.get("a") == NOT_SET
    answer = await asker.ask(
        "set_parameters_atomically", "SetParametersAtomically", {"parameters": request["parameters"][:1]}
    )
    assert answer.result.successful
    assert asker.store.get("a") == typed_value("a", 1)


async def test_a_type_that_does_not_exist_is_refused(asker: Asker) -> None:
    request = {"parameters": [{"name": "a", "value": {"type": 77}}]}
    answer = await asker.ask("set_parameters", "SetParameters", request)
    assert not answer.results[0].successful
    assert "77" in answer.results[0].reason


async def test_events_are_published(asker: Asker) -> None:
    inbox = Inbox()
    await asker.graph.subscribe(PARAMETER_EVENTS, rcl_interfaces().message("ParameterEvent"), inbox.store)
    asker.store.apply({"new": typed_value("", True), "port": NOT_SET, "gains.p": typed_value("", "x")})
    await until(lambda: inbox.payloads)
    event = rcl_interfaces().codec("ParameterEvent").decode(inbox.payloads[-1])
    assert event.node == "/lab/board"
    assert abs(event.stamp.to_s() - asker.graph.now().to_s()) < 60
    (new,), (changed,), (deleted,) = event.new_parameters, event.changed_parameters, event.deleted_parameters
    assert (new.name, new.value.type, new.value.bool_value) == ("new", ParameterType.BOOL, True)
    assert (changed.name, changed.value.string_value) == ("gains.p", "x")
    assert deleted.name == "port"


async def test_closing_removes_the_services(asker: Asker) -> None:
    await asker.services.close()
    await asker.services.close()
    asker.store.apply({"a": typed_value("", 1)})
    snapshot = await asker.graph.snapshot()
    assert not snapshot.services
    assert PARAMETER_EVENTS not in snapshot.topics

from __future__ import annotations

import pytest
import pytest_asyncio

from rostether.errors import ConfigError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.node_parameters import NodeParameters
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore


@pytest_asyncio.fixture
async def graph() -> TypedGraph:
    return TypedGraph(await MemoryNetwork().join("/node"), TypeStore(Registry()))


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["/node/rate"], 0),
        (["/node/rate", "/camera/rate"], 0),
        (["/camera/rate", "/rate"], 0),
        (["/rate"], 0),
        (["/other/rate"], 9),
        ([], 9),
    ],
)
async def test_the_first_place_with_a_value_is_used(
    graph: TypedGraph, names: list[str], expected: int
) -> None:
    for value, name in enumerate(names):
        await graph.set_param(name, value)
    assert await NodeParameters(graph, "camera/", "").value(9, "rate") == expected


async def test_a_parameter_may_have_several_names(graph: TypedGraph) -> None:
    await graph.set_param("~ip", "a, b,")
    parameters = NodeParameters(graph)
    assert await parameters.text("", "address", "ip") == "a, b,"
    assert await parameters.texts("address", "ip") == ("a", "b")


async def test_a_flag_is_true_or_false(graph: TypedGraph) -> None:
    parameters = NodeParameters(graph)
    await graph.set_param("~on", 1)
    assert await parameters.flag(False, "on", accepts_integers=True) is True
    with pytest.raises(ConfigError, match="~on must be true or false, not 1"):
        await parameters.flag(False, "on")


@pytest.mark.parametrize("value", [True, "7", 0, 8])
async def test_an_integer_outside_its_limits_is_refused(graph: TypedGraph, value: ParamValue) -> None:
    await graph.set_param("~count", value)
    with pytest.raises(ConfigError, match="~count must be a whole number from 1 to 7"):
        await NodeParameters(graph).integer(1, 1, 7, "count")


async def test_a_value_of_another_type_is_refused(graph: TypedGraph) -> None:
    await graph.set_param("~gain", True)
    with pytest.raises(ConfigError, match="~gain must be a number, not True"):
        await NodeParameters(graph).number(1.0, "gain")
    with pytest.raises(ConfigError, match="~gain must map names"):
        await NodeParameters(graph).mapping("gain")

"""The parameters of one node: changes of several at once, listeners, limits."""

from __future__ import annotations

import pytest

from rostether.errors import GraphError, SerializationError
from rostether.graph.ports import ParamValue
from rostether.ros2.parameters.store import (
    MAX_ASKED_NAMES,
    MAX_NAME_CHARACTERS,
    MAX_PARAMETERS,
    Changes,
    ParameterStore,
)
from rostether.ros2.parameters.typed_value import NOT_SET, TypedValue, typed_value


def value(content: ParamValue) -> TypedValue:
    return typed_value("", content)


def test_every_node_has_use_sim_time() -> None:
    assert ParameterStore().names() == ["use_sim_time"]
    assert ParameterStore().get("use_sim_time") == value(False)
    assert ParameterStore({"use_sim_time": True}).get("use_sim_time") == value(True)
    for wrong in (value(1), NOT_SET):
        store = ParameterStore()
        with pytest.raises(GraphError, match="use_sim_time must be a bool"):
            store.apply({"use_sim_time": wrong})
        assert store.get("use_sim_time") == value(False)


def test_changes_are_reported_by_kind() -> None:
    store = ParameterStore({"old": 1, "gone": 2})
    reported: list[Changes] = []
    store.listen(reported.append)
    store.apply({"old": value("x"), "new": value(3.0), "gone": NOT_SET, "never": NOT_SET})
    assert reported == [Changes({"new": value(3.0)}, {"old": value("x")}, ["gone"])]
    store.apply({"never": NOT_SET})
    store.unlisten(reported.append)
    store.unlisten(reported.append)
    store.apply({"new": value(4)})
    assert len(reported) == 1
    assert store.names() == ["new", "old", "use_sim_time"]


def test_all_values_are_set_or_none() -> None:
    store = ParameterStore()
    for wrong in ("", "x" * (MAX_NAME_CHARACTERS + 1)):
        with pytest.raises(GraphError, match="name"):
            store.apply({"a": value(1), wrong: value(1)})
    assert store.get("a") is NOT_SET


def test_requested_parameters_are_declared() -> None:
    store = ParameterStore()
    store.declare("gain")
    store.declare("")
    assert store.declared_names() == ["gain", "use_sim_time"]
    assert store.names() == ["use_sim_time"]
    store.apply({"gain": value(1)})
    assert store.declared_names() == ["gain", "use_sim_time"]
    store.apply({"gain": NOT_SET})
    assert store.declared_names() == ["gain", "use_sim_time"]
    for number in range(2 * MAX_ASKED_NAMES):
        store.declare(f"noise{number}")
    assert len(store.declared_names()) == MAX_ASKED_NAMES + 1


def test_parameters_are_bounded() -> None:
    store = ParameterStore()
    store.apply({f"p{number}": value(1) for number in range(MAX_PARAMETERS - 1)})
    with pytest.raises(GraphError, match="at most"):
        store.apply({"one.more": value(1)})
    store.apply({"p0": value(2)})
    assert store.get("p0") == value(2)


def test_initial_values_are_checked() -> None:
    with pytest.raises(SerializationError, match="gain"):
        ParameterStore({"gain": [1, "x"]})
    with pytest.raises(GraphError, match="bool"):
        ParameterStore({"use_sim_time": "yes"})


def test_a_failing_listener_does_not_affect_others(caplog: pytest.LogCaptureFixture) -> None:
    store = ParameterStore()
    reported: list[Changes] = []

    def fail(_: Changes) -> None:
        raise ZeroDivisionError("a mistake")

    store.listen(fail)
    store.listen(reported.append)
    store.apply({"a": value(1)})
    assert len(reported) == 1
    assert "ZeroDivisionError: a mistake" in caplog.text

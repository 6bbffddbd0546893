from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import rostether.sync
from rostether.device import Device
from rostether.errors import UnknownTypeError
from rostether.graph.typed_graph import TypedGraph
from rostether.msg import sensor_msgs, std_msgs
from rostether.msg.std_msgs import String
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.type_classes import name_of_type
from rostether.srv import std_srvs
from rostether.srv.std_srvs import SetBool

WRITER = Path(__file__).parents[3] / "scripts" / "write-message-stubs"


def test_the_stubs_are_those_of_the_definitions() -> None:
    subprocess.run([sys.executable, WRITER, "--check"], check=True)


def test_classes() -> None:
    assert String(data="x").data == "x"
    assert sensor_msgs.NavSatFix().status.status == 0
    with pytest.raises(AttributeError, match="no message 'Strng'"):
        _ = std_msgs.Strng  # type: ignore[attr-defined]


def test_messages_of_the_same_definition_are_instances() -> None:
    received = TypeStore(Registry()).codec("sensor_msgs/Range").decode(bytes(33))
    assert isinstance(received, sensor_msgs.Range)
    assert isinstance(received.header, std_msgs.Header)
    other = Registry(bundled=False)
    other.add_full_text("std_msgs/String", "string text")
    assert not isinstance(TypeStore(other).codec("std_msgs/String").message_class(), String)


def test_service_classes() -> None:
    assert name_of_type(SetBool) == "std_srvs/SetBool"
    assert std_srvs.SetBoolResponse(success=True).success
    with pytest.raises(AttributeError, match="no service 'SetBol'"):
        _ = std_srvs.SetBol  # type: ignore[attr-defined]
    with pytest.raises(UnknownTypeError, match="is not a type; write its name"):
        name_of_type(dict)


def test_devices_and_graphs_have_the_same_methods() -> None:
    assert _public(Device) - _public(TypedGraph) == {"connected", "wait_connected"}
    assert _public(Device) - _public(rostether.sync.Device) == set()
    assert _public(TypedGraph) - _public(rostether.sync.Graph) == {"changes"}


def _public(kind: type) -> set[str]:
    return {name for name in dir(kind) if not name.startswith("_")}

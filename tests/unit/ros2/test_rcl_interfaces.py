from __future__ import annotations

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.registry import Registry
from rostether.ros2.rcl_interfaces import rcl_interfaces
from rostether.serde.store import TypeStore


def test_the_types_can_be_added_to_another_registry() -> None:
    registry = Registry(bundled=False)
    rcl_interfaces().add_to(registry)
    service = registry.service_type("rcl_interfaces/DescribeParameters")
    assert service == rcl_interfaces().service("DescribeParameters")
    request = TypeStore(registry).codec(service.request.name).encode({"names": ["gain"]})
    assert request == b"\x01\0\0\0\x04\0\0\0gain"


def test_an_invalid_service_is_refused() -> None:
    with pytest.raises(DefinitionError):
        Registry(bundled=False).add_service_text("test/Broken", "int32\n---\n")

from __future__ import annotations

import pytest

from rostether.gateways.rosbridge.cdr_form import CdrForm
from rostether.msgdef.registry import Registry
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.serde.store import TypeStore


@pytest.mark.parametrize("registry", [Registry(), NativeRegistry.from_environment(environ={})])
def test_messages_as_ros2_has_them(registry: Registry) -> None:
    payload = TypeStore(registry).codec("std_msgs/Header").encode({"frame_id": "map"})
    form = CdrForm(registry)
    header = registry.message_type("std_msgs/Header")
    cdr = bytes.fromhex("00010000 00000000 00000000 04000000 6d617000")
    assert form.to_cdr(header, payload) == cdr
    assert "builtin_interfaces/Time stamp\n" in form.full_text(header)

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.msgdef.registry import Registry
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeClasses, types_of
from rostether.serde.store import TypeStore


def store_of(*paths: Path) -> TypeStore:
    registry = NativeRegistry.from_environment(paths, environ={})
    return TypeStore(registry, NativeClasses(registry))


def test_fields_that_are_not_given_have_their_defaults() -> None:
    codec = store_of().codec("geometry_msgs/PoseStamped")
    assert codec.message_class().pose.orientation.w == 1.0
    pose = codec.decode(codec.encode({"pose": {"orientation": {"x": 0.5}}})).pose
    assert (pose.orientation.x, pose.orientation.w, pose.position.x) == (0.5, 1.0, 0.0)


def test_defaults_of_every_kind(tmp_path: Path) -> None:
    folder = tmp_path / "own_msgs" / "msg"
    folder.mkdir(parents=True)
    (tmp_path / "own_msgs" / "package.xml").write_text(
        '<package format="3"><name>own_msgs</name><version>0.0.0</version></package>'
    )
    (folder / "Thing.msg").write_text(
        'string name "tool"\nbool on true\nuint8[] raw [1, 2]\nint32[2] pair [3, 4]\nint32 plain\n'
    )
    message_class = store_of(tmp_path).codec("own_msgs/msg/Thing").message_class
    thing, other = message_class(), message_class()
    thing.pair.append(5)
    assert (other.name, other.on, other.raw, other.pair, other.plain) == ("tool", True, b"\1\2", [3, 4], 0)


@pytest.mark.parametrize("registry", [Registry(), NativeRegistry.from_environment(environ={})])
def test_the_types_of_both_kinds_of_registries(registry: Registry) -> None:
    payload = TypeStore(registry).codec("std_msgs/Header").encode({"frame_id": "map"})
    types = types_of(registry)
    header = registry.message_type("std_msgs/Header")
    cdr = bytes.fromhex("00010000 00000000 00000000 04000000 6d617000")
    assert types.message(header).converter.to_cdr(payload) == cdr
    assert "builtin_interfaces/Time stamp\n" in types.full_text(header)

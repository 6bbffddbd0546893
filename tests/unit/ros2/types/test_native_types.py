from __future__ import annotations

from pathlib import Path

from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeClasses
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

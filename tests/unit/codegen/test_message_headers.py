from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rostether.codegen.message_headers import MessageHeaders, generate_headers
from rostether.codegen.type_index import TypeIndex
from rostether.msgdef.registry import Registry
from unit.codegen.hostile import write_definitions


def headers(
    root: Path, definitions: dict[str, str], own_paths: tuple[str, ...] = (), names: Iterable[str] = ()
) -> MessageHeaders:
    registry = Registry([write_definitions(root, definitions)], bundled=False)
    wanted = set(names) or {*registry.messages(), *registry.services()}
    return generate_headers(TypeIndex(registry), wanted, own_paths=own_paths)


def test_messages_and_services(tmp_path: Path) -> None:
    made = headers(tmp_path, {"pkg/msg/A.msg": "uint8 x\n", "pkg/srv/B.srv": "A a\n---\n"})
    assert list(made.texts) == ["pkg/A.h", "pkg/B.h"]
    assert made.types == ["pkg/A", "pkg/B"]
    assert made.classes == {"A", "B"}
    assert (made.skipped, made.warnings) == ([], [])


def test_a_broken_definition_affects_only_types_that_need_it(tmp_path: Path) -> None:
    made = headers(
        tmp_path,
        {
            "bad/msg/Broken.msg": "uint8 fine\nwhat is this\n",
            "bad/msg/Fine.msg": "uint8 x\n",
            "bad/msg/Needs.msg": "Broken b\n",
            "good/msg/Needs.msg": "bad/Broken b\n",
            "good/msg/Unknown.msg": "unknown_msgs/Missing b\n",
            "good/msg/Fine.msg": "bad/Fine f\n",
        },
    )
    assert made.types == ["bad/Fine", "good/Fine"]
    broken = f"{tmp_path}/bad/msg/Broken.msg:2:1: 'what is this' is not 'type name' or 'type NAME=value'"
    assert made.skipped[:3] == [
        f"skipped bad/Broken: {broken}",
        f"skipped bad/Needs: {broken}",
        f"skipped good/Needs: {broken}",
    ]
    assert made.skipped[3].startswith("skipped good/Unknown: good/Unknown, field 'b': ")


def test_many_broken_definitions_of_a_package(tmp_path: Path) -> None:
    made = headers(tmp_path, {f"pkg/msg/A{number}.msg": "unknown_msgs/Missing b\n" for number in range(9)})
    assert [line.partition(":")[0] for line in made.skipped] == [f"skipped pkg/A{each}" for each in range(5)]
    assert made.skipped[4].endswith("(and 4 more of this package)")


def test_a_message_that_contains_itself(tmp_path: Path) -> None:
    made = headers(tmp_path, {"pkg/msg/A.msg": "B b\n", "pkg/msg/B.msg": "A[] a\n"})
    assert made.types == []
    assert "a message cannot contain itself: pkg/A -> pkg/B -> pkg/A" in made.skipped[0]


def test_packages_that_conflict_with_the_librarys_own_headers(tmp_path: Path) -> None:
    made = headers(
        tmp_path,
        {"ros/msg/Time2.msg": "", "tf/msg/tf.msg": "", "tf/msg/fine.msg": "", "a/msg/A.msg": "tf/tf tf\n"},
        own_paths=("ros/time.h", "tf/tf.h"),
    )
    assert made.types == ["tf/fine"]
    assert [line.partition(":")[0] for line in made.skipped] == [
        "skipped a/A",
        "skipped ros/Time2",
        "skipped tf/tf",
    ]


def test_a_service_and_a_message_of_one_name(tmp_path: Path) -> None:
    made = headers(
        tmp_path,
        {
            "pkg/msg/A.msg": "",
            "pkg/srv/A.srv": "---\n",
            "pkg/msg/BRequest.msg": "",
            "pkg/srv/B.srv": "---\n",
            "pkg/srv/C.srv": "---\n",
        },
    )
    assert made.types == ["pkg/A", "pkg/BRequest", "pkg/C"]
    assert made.skipped == [
        "skipped the service pkg/A: a message has the same name; rename one",
        "skipped pkg/B: there is also a message pkg/BRequest; rename one, because C++ cannot have both",
    ]
    made = headers(tmp_path, {}, names=["pkg/B"])
    assert "skipped pkg/B: there is also a message pkg/BRequest; rename one" in made.skipped[0]


def test_names_that_differ_only_in_case(tmp_path: Path) -> None:
    made = headers(
        tmp_path, {"pkg/msg/Foo.msg": "", "pkg/msg/foo.msg": "", "tf/msg/Tf.msg": ""}, ("tf/tf.h",)
    )
    assert made.types == ["pkg/Foo", "pkg/foo", "tf/Tf"]
    assert [line.partition(" differ")[0] for line in made.warnings] == [
        "pkg/Foo.h and pkg/foo.h",
        "tf/Tf.h and tf/tf.h",
    ]

"""The content of the MicroPython library; tests/firmware/micropython runs it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.codegen.micropython_library import render_micropython_library, write_micropython_library
from rostether.errors import ConfigError, UnknownTypeError
from rostether.msgdef.registry import Registry


def registry_of(folder: Path, **definitions: str) -> Registry:
    """Return the bundled types, and messages given as package__Name."""
    for name, text in definitions.items():
        package, _, short_name = name.partition("__")
        (folder / package / "msg").mkdir(parents=True, exist_ok=True)
        (folder / package / "msg" / f"{short_name}.msg").write_text(text)
    return Registry([folder])


def test_names_that_python_has_get_an_underscore(tmp_path: Path) -> None:
    text = "uint8 from=1\nuint8 serialize\nuint8 self\nuint8 lambda\nuint8 lambda_\nuint8 len\n"
    registry = registry_of(tmp_path, robot__Part=text)
    library = render_micropython_library(registry, packages=["robot"])
    module = library.files["robot/msg/_Part.py"].decode()
    assert "    from_ = 1\n" in module
    assert "def __init__(self, serialize_=0, self_=0, lambda__=0, lambda_=0, len=0):" in module
    compile(module, "_Part.py", "exec")


def test_packages_that_hide_modules_of_the_board_are_skipped_with_their_users(tmp_path: Path) -> None:
    registry = registry_of(
        tmp_path, time__Zone="uint8 x\n", ros__Key="uint8 x\n", robot__Watch="time/Zone zone\n"
    )
    library = render_micropython_library(registry)
    assert [each.partition(":")[0] for each in library.skipped] == [
        "skipped robot/Watch",
        "skipped ros/Key",
        "skipped time/Zone",
    ]
    assert {"std_msgs/msg/_String.py", "examples/blink.py"} <= set(library.files)
    assert not any(path.startswith("time/") for path in library.files)


def test_two_types_with_one_name_in_python_are_reported(tmp_path: Path) -> None:
    registry = registry_of(tmp_path, robot__None="uint8 x\n", robot__None_="uint8 x\n")
    library = render_micropython_library(registry, packages=["robot"])
    assert library.skipped == ("skipped robot/None_: another type has its name in Python; rename one",)


def test_constants_are_those_of_the_definition(tmp_path: Path) -> None:
    text = 'float64 INFINITE=-inf\nstring TEXT=it\'s "é"\nbool YES=True\nuint64 MOST=18446744073709551615\n'
    library = render_micropython_library(registry_of(tmp_path, robot__Limits=text), packages=["robot"])
    names: dict[str, object] = {"_Message": object}
    module = library.files["robot/msg/_Limits.py"].decode()
    exec(module.replace("from ros.message import Message as _Message", ""), names)
    limits = names["Limits"]
    found = [getattr(limits, name) for name in ("INFINITE", "TEXT", "YES", "MOST")]
    assert found == [float("-inf"), 'it\'s "é"', True, 2**64 - 1]


def test_a_program_has_what_it_imports_and_single_types_can_be_added(tmp_path: Path) -> None:
    (tmp_path / "main.py").write_text("from std_msgs.msg import Empty as E\nfrom .msg import A\nimport os\n")
    library = render_micropython_library(
        Registry(), for_program=tmp_path, packages=["geometry_msgs/PoseStamped"]
    )
    assert library.skipped == ()
    assert set(library.types) == {
        "std_msgs/Empty",
        "std_msgs/Header",
        *(f"geometry_msgs/{name}" for name in ("Point", "Pose", "PoseStamped", "Quaternion")),
    }
    with pytest.raises(UnknownTypeError, match="did you mean geometry_msgs/Pose"):
        render_micropython_library(Registry(), packages=["geometry_msgs/Poze"])
    (tmp_path / "main.py").unlink()
    with pytest.raises(ConfigError, match="no Python files in"):
        render_micropython_library(Registry(), for_program=tmp_path)


def test_an_older_library_is_replaced_as_a_whole(tmp_path: Path) -> None:
    assert not write_micropython_library(tmp_path, Registry(), packages=["std_srvs"]).replaced
    assert write_micropython_library(tmp_path, Registry(), packages=["std_msgs"]).replaced
    assert {each.name for each in (tmp_path / "ros_lib").iterdir()} == {"ros", "std_msgs"}

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.msgdef.interface import MessageType
from rostether.recording.bag.writer import BagWriter
from unit.cli.command_shell import Shell
from unit.recording.bags import START_NS, STRING, connection

POINT = """geometry_msgs/Point point
  float64 x
  float64 y
  float64 z
"""


def test_show(shell: Shell) -> None:
    assert shell.output("msg", "show", "std_msgs/String") == "string data\n\n"
    assert shell.output("msg", "info", "std_msgs/String.msg") == "string data\n\n"
    assert (
        shell.output("srv", "show", "std_srvs/SetBool") == "bool data\n---\nbool success\nstring message\n\n"
    )
    shown = shell.output("msg", "show", "sensor_msgs/Range")
    assert shown.startswith("uint8 ULTRASOUND=0\nuint8 INFRARED=1\nstd_msgs/Header header\n  uint32 seq\n")
    assert POINT in shell.output("msg", "show", "geometry_msgs/PointStamped")


def test_a_name_without_its_package_shows_all_that_have_it(shell: Shell) -> None:
    assert shell.output("msg", "show", "UInt16") == "[std_msgs/UInt16]:\nuint16 data\n\n"
    assert (
        shell.output("srv", "show", "Trigger") == "[std_srvs/Trigger]:\n---\nbool success\nstring message\n\n"
    )


def test_types_of_a_recording(shell: Shell, tmp_path: Path) -> None:
    arm = MessageType("arm/Angles", "*", "arm/Angle first\n" + "=" * 80 + "\nMSG: arm/Angle\nint16 degrees\n")
    path = tmp_path / "arm.bag"
    writer = BagWriter(path)
    writer.write(writer.add_connection(connection("/angles", arm)), START_NS, [bytes(2)])
    writer.close()
    shown = "arm/Angle first\n  int16 degrees\n\n"
    assert shell.output("msg", "show", "-b", str(path), "arm/Angles") == shown
    assert shell.output("msg", "show", "-b", str(path), "Angle") == "[arm/Angle]:\nint16 degrees\n\n"
    assert "arm.bag has no type std_msgs/String;" in shell.failure(
        "msg", "show", "-b", str(path), "std_msgs/String"
    )


def test_an_invalid_definition_of_a_recording_hides_no_other_types(shell: Shell, tmp_path: Path) -> None:
    path = tmp_path / "arm.bag"
    writer = BagWriter(path)
    for kind in (MessageType("arm/Bad", "*", "no definition!"), STRING):
        writer.write(writer.add_connection(connection("/topic", kind)), START_NS, [bytes(4)])
    writer.close()
    assert shell.output("msg", "show", "-b", str(path), "std_msgs/String") == "string data\n\n"
    assert "arm/Bad:1:4: " in shell.failure("msg", "show", "-b", str(path), "arm/Bad")


def test_the_type_may_come_through_a_pipe(shell: Shell) -> None:
    assert shell.output("msg", "show", stdin="\nstd_msgs/String\n") == "string data\n\n"
    assert "stdin contains no" in shell.failure("msg", "show", code=2)


def test_json(shell: Shell) -> None:
    assert shell("srv", "show", "--json", "std_srvs/SetBool").records == [
        {
            "type": "std_srvs/SetBool",
            "md5sum": "09fb03525b03e7ea1fd3992bafd87e16",
            "request": {"constants": [], "fields": [{"type": "bool", "name": "data"}]},
            "response": {
                "constants": [],
                "fields": [{"type": "bool", "name": "success"}, {"type": "string", "name": "message"}],
            },
        }
    ]
    record = shell("msg", "show", "--json", "sensor_msgs/Range").records[0]
    assert record["constants"][1] == {"type": "uint8", "name": "INFRARED", "value": 1}


def test_md5(shell: Shell) -> None:
    assert shell.output("msg", "md5", "std_msgs/String") == "992ce8a1687cec8c8bd883ec73ca41d1\n"
    assert shell.output("msg", "md5", "UInt16") == "[std_msgs/UInt16]: 1df79edf208b629fe6b81923a544552d\n"
    assert shell.output("srv", "md5", "std_srvs/SetBool") == "09fb03525b03e7ea1fd3992bafd87e16\n"


def test_lists(shell: Shell) -> None:
    assert "sensor_msgs/Range\n" in shell.output("msg", "list")
    assert (
        shell.output("srv", "package", "std_srvs") == "std_srvs/Empty\nstd_srvs/SetBool\nstd_srvs/Trigger\n"
    )
    assert (
        shell.output("srv", "package", "-s", "std_srvs")
        == "std_srvs/Empty std_srvs/SetBool std_srvs/Trigger\n"
    )
    assert "std_msgs" in shell.output("msg", "packages").split()
    assert "std_srvs" not in shell.output("msg", "packages", "-s").split()


def test_own_definitions(shell: Shell, tmp_path: Path) -> None:
    folder = tmp_path / "my_robot" / "msg"
    folder.mkdir(parents=True)
    (folder / "Probe.msg").write_text("# how deep\nfloat32 depth  # meters\nuint8 MAX = 7\n")
    arguments = ("--msg-path", str(tmp_path))
    assert (
        shell.output("msg", "show", *arguments, "Probe")
        == "[my_robot/Probe]:\nuint8 MAX=7\nfloat32 depth\n\n"
    )
    assert "# how deep" in shell.output("msg", "show", "--raw", *arguments, "my_robot/Probe")
    assert shell.output("msg", "package", *arguments, "my_robot") == "my_robot/Probe\n"
    assert "no such folder" in shell.failure("msg", "list", "--msg-path", str(tmp_path / "nope"))


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["msg", "show", "no_package/Nope"], 1, "--msg-path"),
        (["msg", "show", "Nope"], 1, "no package has a message 'Nope'"),
        (["srv", "md5", "Nope"], 1, "no package has a service 'Nope'"),
        (["msg", "package", "nope"], 1, "no package 'nope' with definitions"),
        (["msg", "show", "std_msgs::String"], 2, "write package/Name"),
        (["msg", "show", "std_msgs.String"], 2, "write package/Name"),
        (["msg", "sho"], 2, "did you mean show"),
    ],
)
def test_mistakes(shell: Shell, arguments: list[str], code: int, text: str) -> None:
    assert text in shell.failure(*arguments, code=code)


def write_package(folder: Path, messages: dict[str, str]) -> str:
    (folder / "msg").mkdir()
    (folder / "package.xml").write_text("<package><name>hostile</name></package>")
    for name, text in messages.items():
        (folder / "msg" / f"{name}.msg").write_text(text)
    return str(folder)


@pytest.mark.parametrize("options", [[], ["--ros2"]])
def test_a_type_inside_itself_is_refused(shell: Shell, tmp_path: Path, options: list[str]) -> None:
    path = write_package(tmp_path, {"Loop": "Loop next"})
    error = shell.failure("msg", "show", *options, "--msg-path", path, "hostile/Loop")
    assert "a message cannot contain itself" in error


@pytest.mark.parametrize("options", [[], ["--ros2"]])
def test_a_type_of_too_many_lines_is_refused(shell: Shell, tmp_path: Path, options: list[str]) -> None:
    levels = {f"T{n}": "".join(f"T{n + 1}[] f{k}\n" for k in range(4)) for n in range(24)}
    path = write_package(tmp_path, {**levels, "T24": "string x"})
    error = shell.failure("msg", "show", *options, "--msg-path", path, "hostile/T0")
    assert "has more than 10000 lines" in error
    assert "T24[] f3" in shell.output("msg", "show", *options, "--msg-path", path, "hostile/T22")

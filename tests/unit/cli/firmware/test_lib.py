from __future__ import annotations

from pathlib import Path

from unit.cli.command_shell import Shell


def test_all(shell: Shell, tmp_path: Path) -> None:
    reported = shell.output("firmware", "lib", str(tmp_path))
    assert reported.startswith(f"wrote {tmp_path}/ros_lib: ")
    assert reported.endswith(" packages\n")
    assert (tmp_path / "ros_lib/src/ros.h").is_file()
    assert (tmp_path / "ros_lib/src/visualization_msgs/Marker.h").is_file()
    assert shell.output("firmware", "lib", str(tmp_path)).startswith(f"replaced {tmp_path}/ros_lib: ")


def test_for_a_sketch_with_own_messages(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "my_robot").mkdir()
    (tmp_path / "my_robot/Wheels.msg").write_text("float32 left\n")
    sketch = tmp_path / "drive.ino"
    sketch.write_text("#include <ros.h>\n#include <my_robot/Wheels.h>\n")
    shell.output(
        "firmware", "lib", str(tmp_path), "--for", str(sketch), "--msg-path", str(tmp_path / "my_robot")
    )
    assert (tmp_path / "ros_lib/src/my_robot/Wheels.h").is_file()
    assert not (tmp_path / "ros_lib/src/visualization_msgs").exists()


def test_messages_that_other_libraries_include(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "Robot/src").mkdir(parents=True)
    (tmp_path / "Robot/src/Robot.h").write_text("#include <sensor_msgs/Imu.h>\n")
    (tmp_path / "x.ino").write_text("#include <Robot.h>\n")
    shell.output("firmware", "lib", str(tmp_path), "--for", str(tmp_path / "x.ino"))
    assert (tmp_path / "ros_lib/src/sensor_msgs/Imu.h").is_file()


def test_skipped_messages_are_reported_and_the_others_written(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "bad/msg").mkdir(parents=True)
    (tmp_path / "bad/msg/A.msg").write_text("uint8 x\nfloat 32 y\n")
    result = shell("firmware", "lib", str(tmp_path), "--msg-path", str(tmp_path / "bad"))
    assert result.code == 1
    assert result.err.startswith(f"skipped bad/A: {tmp_path}/bad/msg/A.msg:2:1: ")
    assert result.err.count("\n") == 1
    assert (tmp_path / "ros_lib/src/std_msgs/String.h").is_file()


def test_an_unknown_message_of_a_sketch_is_reported_with_its_line(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "x.ino").write_text("#include <ros.h>\n#include <sensor_msgs/Rang.h>\n")
    result = shell("firmware", "lib", str(tmp_path), "--for", str(tmp_path / "x.ino"))
    assert result.code == 1
    assert result.err.startswith(
        f"{tmp_path}/x.ino:2: package 'sensor_msgs' has no message 'Rang'; did you mean"
    )
    assert (tmp_path / "ros_lib/src/ros.h").is_file()


def test_json(shell: Shell, tmp_path: Path) -> None:
    (record,) = shell("firmware", "lib", str(tmp_path), "--package", "std_srvs", "--json").records
    assert {"std_srvs/Empty", "std_srvs/SetBool", "std_srvs/Trigger"} <= set(record.pop("types"))
    assert record == {"path": f"{tmp_path}/ros_lib", "replaced": False, "skipped": [], "warnings": []}


def test_failures(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "ros_lib").mkdir()
    (tmp_path / "ros_lib/mine.txt").write_text("mine")
    assert "is not a generated library and is not changed;" in shell.failure("firmware", "lib", str(tmp_path))
    assert "no sketch at" in shell.failure("firmware", "lib", str(tmp_path), "--for", "nothing.ino")
    assert "no package 'std'" in shell.failure("firmware", "lib", str(tmp_path), "--package", "std")
    assert "no such folder" in shell.failure("firmware", "lib", str(tmp_path), "--msg-path", "/nowhere")
    assert "Missing argument" in shell.failure("firmware", "lib", code=2)


def test_micropython_for_a_program(shell: Shell, tmp_path: Path) -> None:
    program = tmp_path / "main.py"
    program.write_text("import ros\nfrom sensor_msgs.msg import Range\nfrom std_srvs.srv import SetBool\n")
    reported = shell.output("firmware", "lib", str(tmp_path), "--micropython", "--for", str(program))
    # A Range has a Header.
    assert reported == f"wrote {tmp_path}/ros_lib: 3 types of 3 packages\n"
    written = {
        str(each.relative_to(tmp_path / "ros_lib")) for each in (tmp_path / "ros_lib").rglob("_[A-Z]*.py")
    }
    assert written == {"sensor_msgs/msg/_Range.py", "std_msgs/msg/_Header.py", "std_srvs/srv/_SetBool.py"}
    assert (tmp_path / "ros_lib/ros/node_handle.py").is_file()
    reported = shell.output(
        "firmware", "lib", str(tmp_path), "--micropython", "--messages", "std_msgs/String"
    )
    assert reported == f"replaced {tmp_path}/ros_lib: 1 type of 1 package\n"


def test_micropython_for_programs_that_cannot_be_read(shell: Shell, tmp_path: Path) -> None:
    program = tmp_path / "main.py"
    command = ("firmware", "lib", str(tmp_path), "--micropython", "--for", str(program))
    assert shell(*command).err == (
        f"rostether: error: cannot read {program}: No such file or directory; name the program of the board\n"
    )
    program.write_text("from std_msgs.msg import (\n")
    assert shell(*command).err.startswith(f"rostether: error: {program} is not a Python program: ")
    program.write_text("from std_msgs.msg import Strin\n")
    result = shell(*command)
    assert result.code == 1
    assert result.err.startswith(f"{program}:1: package 'std_msgs' has no message 'Strin'; did you mean")
    folder = tmp_path / "ros_lib"
    result = shell("firmware", "lib", str(folder), "--micropython")
    assert result.err.startswith(
        f"rostether: error: {folder} is a library itself; give the folder that contains it"
    )

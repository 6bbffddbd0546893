"""`rostether interface`, with the words and the output of `ros2 interface`."""

from __future__ import annotations

from pathlib import Path

from unit.cli.command_shell import Shell


def test_show(shell: Shell) -> None:
    assert shell.output("interface", "show", "std_msgs/msg/String") == "string data\n"
    assert shell.output("interface", "show", "std_srvs/srv/SetBool") == (
        "bool data\n---\nbool success\nstring message\n"
    )
    parts = "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n"
    assert shell.output("interface", "show", "example_interfaces/action/Fibonacci") == parts
    assert shell.output("interface", "show", "--no-comments", "-", stdin="std_msgs/msg/String\n") == (
        "string data\n"
    )
    assert "no ROS 2 package 'a' is known for a/action/B" in shell.failure("interface", "show", "a/action/B")
    assert "write PACKAGE/msg/NAME" in shell.failure("interface", "show", "String", code=2)


def test_comments_as_ros2_shows_them(shell: Shell, tmp_path: Path) -> None:
    """As `ros2 interface show` of Jazzy prints them: those of nested types only with --all-comments."""
    for folder, text in {
        "msg/Tag": "# A label.\n\nstring name  # unique\nuint8 RED=1\n",
        "srv/Mark": "# Marks a place.\nTag tag  # the label\n\n---\n# How it went.\nbool done\n",
    }.items():
        file = tmp_path / "own_msgs" / f"{folder}.{folder[:3]}"
        file.parent.mkdir(parents=True)
        file.write_text(text)
    (tmp_path / "own_msgs" / "package.xml").write_text('<package format="3"><name>own_msgs</name></package>')

    def show(*options: str) -> str:
        return shell.output("interface", "show", "own_msgs/srv/Mark", "--msg-path", str(tmp_path), *options)

    raw = shell.output(
        "srv", "show", "--ros2", "zenoh", "--raw", "own_msgs/Mark", "--msg-path", str(tmp_path)
    )
    assert raw == "# Marks a place.\nTag tag  # the label\n\n---\n# How it went.\nbool done\n"
    nested = "\tstring name\n\tuint8 RED=1\n"
    assert show() == (f"# Marks a place.\nTag tag  # the label\n{nested}\n---\n# How it went.\nbool done\n")
    assert show("--no-comments") == f"Tag tag\n{nested}---\nbool done\n"
    assert "\t# A label.\n\n\tstring name  # unique\n" in show("--all-comments")


def test_lists(shell: Shell, tmp_path: Path) -> None:
    folder = tmp_path / "own_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Tag.msg").write_text("wstring name\n")
    (tmp_path / "own_msgs" / "package.xml").write_text('<package format="3"><name>own_msgs</name></package>')
    listed = shell.output("interface", "list", "--msg-path", str(tmp_path)).splitlines()
    assert listed[0] == "Messages:"
    assert {"    own_msgs/msg/Tag", "    std_srvs/srv/SetBool", "Services:"} <= set(listed)
    services = shell.output("interface", "list", "-s")
    assert "Messages:" not in services
    assert "std_msgs/msg" not in services
    own = shell.output("interface", "package", "own_msgs", "--msg-path", str(tmp_path))
    assert own == "own_msgs/msg/Tag\n"
    assert shell.output("interface", "package", "std_srvs").splitlines() == [
        "std_srvs/srv/Empty",
        "std_srvs/srv/SetBool",
        "std_srvs/srv/Trigger",
    ]
    actions = shell.output("interface", "list", "-a").splitlines()
    assert actions[:2] == ["Actions:", "    example_interfaces/action/Fibonacci"]
    assert shell.output("interface", "package", "-a", "example_interfaces").splitlines() == [
        "example_interfaces/action/Fibonacci"
    ]
    assert "example_interfaces" in shell.output("interface", "packages", "--only-actions").splitlines()
    assert "did you mean std_srvs?" in shell.failure("interface", "package", "std_srv")
    assert "no package 'none'" in shell.failure("interface", "package", "none")
    assert "std_srvs" in shell.output("interface", "packages").splitlines()
    assert "std_srvs" not in shell.output("interface", "packages", "-m").splitlines()


def test_proto(shell: Shell) -> None:
    assert shell.output("interface", "proto", "std_msgs/msg/String") == "\"data: ''\n\"\n"
    assert shell.output("interface", "proto", "--no-quotes", "std_srvs/srv/SetBool") == "data: false\n"
    goal = shell.output("interface", "proto", "--no-quotes", "example_interfaces/action/Fibonacci")
    assert goal == "order: 0\n"
    assert "w: 1.0" in shell.output("interface", "proto", "geometry_msgs/msg/Quaternion")

"""`topic echo -b` and `topic list -b`, compared with Debian's rostopic."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from rostether.msgdef.registry import Registry
from rostether.recording.files import create_recording
from rostether.recording.recorded import Connection
from rostether.serde.store import TypeStore
from unit.cli.command_shell import Shell


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    path = tmp_path / "drive.bag"
    writer = create_recording(path)
    registry = Registry()
    store = TypeStore(registry)
    ranges = writer.add_connection(
        Connection("/ultrasound", registry.message_type("sensor_msgs/Range"), "/board")
    )
    texts = writer.add_connection(Connection("/chatter", registry.message_type("std_msgs/String"), "/board"))
    for number in range(3):
        writer.write(
            ranges, number * 10**9 + 5, [store.codec("sensor_msgs/Range").encode({"range": number / 2})]
        )
    writer.write(texts, 1, [store.codec("std_msgs/String").encode({"data": "hello"})])
    writer.close()
    return path


@pytest.mark.parametrize(
    "arguments",
    [
        ["/ultrasound"],
        ["ultrasound/range"],
        ["-n", "2", "/ultrasound/range"],
        ["-p", "/ultrasound"],
        ["-p", "/ultrasound/range"],
        ["-a"],
        ["-a", "-n", "2"],
    ],
)
@pytest.mark.ros1
def test_messages_are_printed_as_rostopic_does(shell: Shell, bag: Path, arguments: list[str]) -> None:
    expected = subprocess.run(
        ["/usr/bin/rostopic", "echo", "-b", str(bag), *arguments], capture_output=True, text=True, check=True
    )
    assert shell.output("topic", "echo", "-b", str(bag), *arguments) == expected.stdout


def test_a_filter(shell: Shell, bag: Path) -> None:
    printed = shell.output("topic", "echo", "-b", str(bag), "--filter", "m.range > 0.4", "/ultrasound/range")
    assert printed == "0.5\n---\n1.0\n---\n"


def test_the_topics_of_a_recording(shell: Shell, bag: Path) -> None:
    assert shell.output("topic", "list", "-b", str(bag)) == "/chatter\n/ultrasound\n"


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["-b", "BAG", "/ultrasond"], 1, "drive.bag has no topic /ultrasond; did you mean /ultrasound?"),
        (["-b", "BAG", "/ultrasound/rnge"], 1, "has no field 'rnge'"),
        (["-b", "BAG", "-a", "/ultrasound"], 2, "-a prints all topics of a recording"),
        (["-a"], 2, "-a prints all topics of a recording"),
        (["-b", "BAG", "--offset", "/ultrasound"], 2, "--offset does not work with a recording"),
        (["-b", "none.bag", "/ultrasound"], 1, "cannot read none.bag"),
        (["-b", "BAG"], 2, "Missing argument 'TOPIC[/FIELD]'"),
    ],
)
def test_errors(shell: Shell, bag: Path, arguments: list[str], code: int, words: str) -> None:
    given = [str(bag) if each == "BAG" else each for each in arguments]
    assert words in shell.failure("topic", "echo", *given, code=code)


def test_a_damaged_recording_is_read_as_far_as_possible(shell: Shell, bag: Path, tmp_path: Path) -> None:
    killed = tmp_path / "killed.bag.active"
    shutil.copy(bag, killed)
    with killed.open("r+b") as file:
        file.truncate(killed.stat().st_size - 40)
    result = shell("topic", "echo", "-b", str(killed), "/chatter")
    assert result.out == 'data: "hello"\n---\n'
    assert "only its complete part is read" in result.err

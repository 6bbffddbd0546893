from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import click
import pytest

from rostether.cli.main import rostether, split_special
from rostether.cli.shell import failures
from rostether.cli.shell.failures import error_text, exit_code_of
from rostether.cli.shell.verbs import LazyGroup, Verb
from rostether.cli.verb_table import WORDS_OF_OTHER_TOOLS
from rostether.errors import ConfigError, RostetherError
from unit.cli.command_shell import LiveGraph, Shell


def all_verbs(group: LazyGroup, path: str = "rostether") -> Iterator[tuple[str, click.Command, str]]:
    """Yield every command with its path, and its summary in the help of its group."""
    context = click.Context(group)
    for name, entry in group.verbs.items():
        command = group.get_command(context, name)
        assert command is not None
        yield f"{path} {name}", command, entry.summary
        if isinstance(command, LazyGroup):
            yield from all_verbs(command, f"{path} {name}")


assert isinstance(rostether, LazyGroup)
VERBS = {path: (command, summary) for path, command, summary in all_verbs(rostether)}


@pytest.mark.parametrize("path", VERBS)
def test_every_command_has_a_purpose_and_examples(path: str, shell: Shell) -> None:
    command, summary = VERBS[path]
    text = shell.output(*path.split()[1:], "--help")
    assert summary.endswith(".")
    assert text == shell.output(*path.split()[1:], "-h")
    assert isinstance(command, Verb | LazyGroup)
    # A comment that does not fit beside its command is below it.
    words = text.split()
    for line in command.examples.splitlines():
        assert " ".join(line.split()) in " ".join(words)
    own = path if not path.endswith(" info") else path.removesuffix("info")
    assert own in command.examples or (path.split()[1] in ("msg", "srv") and "show" in command.examples)


def test_version(shell: Shell) -> None:
    for option in ("--version", "-V"):
        assert shell.output(option) == f"rostether, version {version('rostether')}\n"


def test_mistyped_commands_are_reported_with_similar_ones(shell: Shell) -> None:
    assert "no such command 'topc'; did you mean topic?" in shell.failure("topc", code=2)
    assert "no such command 'ecko'; did you mean echo?" in shell.failure("topic", "ecko", code=2)
    assert "did you mean `rostether topic pub`?" in shell.failure("pub", "/chatter", code=2)
    assert "`rostether link record` or `rostether bag record`?" in shell.failure("record", code=2)
    assert "see `rostether --help`" in shell.failure("xyzzy", code=2)
    assert "see `rostether --help`" in shell.failure("stop", code=2)
    for words, meant in (
        ("compile", "firmware build"),
        ("rosmsg", "msg"),
        ("/dev/ttyACM0", "serve /dev/ttyACM0"),
        ("/dev/ttyACM0?baud=9600", "serve '/dev/ttyACM0?baud=9600'"),
        ("board list", "ports"),
    ):
        assert f"did you mean `rostether {meant}`?" in shell.failure(*words.split(), code=2)


def test_suggested_commands_exist(shell: Shell) -> None:
    for words in itertools.chain.from_iterable(WORDS_OF_OTHER_TOOLS.values()):
        assert shell(*(word for word in words.split() if not word.startswith("/")), "--help").code == 0, words
    assert "--nope" in shell.failure("topic", "list", "--nope", code=2)


def test_arguments_that_roslaunch_adds(graph: LiveGraph, shell: Shell) -> None:
    master = f"__master:={graph.uri}"
    assert (
        shell("topic", "list", "__log:=/tmp/x.log", "__name:=lister", "__master:=http://127.0.0.1:9").code
        == 1
    )
    assert shell.output("param", "set", "speed", "1", "__ns:=/arm", master) == ""
    assert shell.output("param", "get", "/arm/speed", master) == "1\n"


@pytest.mark.usefixtures("cold_start")
def test_help_imports_few_modules() -> None:
    code = (
        "import sys; from rostether.cli.main import main; "
        "main(['msg', 'show', '-h']); print(*sys.modules, file=sys.stderr)"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stderr
    heavy = {"asyncio", "random", "rich", "rostether.msgdef.registry", "serialx", "socket", "yaml"}
    assert not heavy & set(loaded.split())


@pytest.mark.usefixtures("cold_start")
def test_serve_imports_only_modules_that_the_first_message_needs() -> None:
    code = "import sys, rostether.cli.bridge.serve, rostether.bridge.supervisor; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    names = {".".join(name.split(".")[:2]) for name in loaded.split()}
    packages = ("dashboard", "firmware", "gateways", "launch", "recording", "robot", "simulation")
    assert not names & {"yaml", "rich", "serialx", "websockets", *(f"rostether.{each}" for each in packages)}


def fail(error: BaseException) -> int:
    raise error


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ConfigError("wrong"), 1),
        (OSError(2, "No such file or directory", "/nope"), 1),
        (ZeroDivisionError("division by zero"), 1),
        (ExceptionGroup("several", [ConfigError("wrong")]), 1),
        (click.UsageError("wrong"), 2),
        (KeyboardInterrupt(), 130),
        (click.exceptions.Exit(3), 3),
        (SystemExit(1), 0),
    ],
)
def test_exit_codes(error: BaseException, code: int, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code_of(lambda: fail(error)) == code
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (ConfigError("a\n  b"), "a b"),
        (OSError(2, "No such file or directory", "/nope"), "/nope: No such file or directory"),
        (OSError(98, "Address in use"), "Address in use"),
        (
            ExceptionGroup(
                "several", [ExceptionGroup("more", [ConfigError("first"), ConfigError("second")])]
            ),
            "first",
        ),
    ],
)
def test_one_line(error: Exception, text: str) -> None:
    assert error_text(error) == text


def test_unexpected_errors_show_how_to_see_more(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert error_text(RostetherError()).startswith("RostetherError")
    assert failures.TRACEBACK_VARIABLE in error_text(ZeroDivisionError("division by zero"))
    monkeypatch.setenv(failures.TRACEBACK_VARIABLE, "1")
    assert exit_code_of(lambda: fail(ZeroDivisionError("division by zero"))) == 1
    assert "Traceback" in capsys.readouterr().err


def test_completion_of_verbs_and_names(
    graph: LiveGraph, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    graph.do(graph.node("setter").set_param("/blink_hz", 2))
    # A busy machine answers late.
    monkeypatch.setattr("rostether.cli.access.completions.ROS1_TIMEOUT_S", 60.0)

    def complete(words: str) -> str:
        monkeypatch.setenv("_ROSTETHER_COMPLETE", "bash_complete")
        monkeypatch.setenv("COMP_WORDS", words)
        monkeypatch.setenv("COMP_CWORD", str(len(words.split(" ")) - 1))
        return shell("ignored").out

    assert complete("rostether to") == "plain,topic\n"
    assert "plain,echo" in complete("rostether topic e")
    assert complete("rostether param get /b") == "plain,/blink_hz\n"
    assert complete("rostether param get b") == "plain,/blink_hz\n"
    assert complete("rostether topic echo /ros") == "plain,/rosout\n"
    assert complete("rostether node info /set") == "plain,/setter\n"
    assert (
        complete("rostether topic pub /a std_msgs/UInt1")
        == "plain,std_msgs/UInt16\nplain,std_msgs/UInt16MultiArray\n"
    )
    assert complete("rostether service find std_srvs/S") == "plain,std_srvs/SetBool\n"
    assert complete("rostether service type /nope") == "\n"


def test_completion_without_a_master_is_silent(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_ROSTETHER_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "rostether topic echo /")
    monkeypatch.setenv("COMP_CWORD", "3")
    result = shell("ignored")
    assert (result.out.strip(), result.err) == ("", "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "rostether", "msg", "show", "std_msgs/Empty"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (ended.returncode, ended.stderr) == (1, "rostether: error: No space left on device\n")


def test_the_arguments_of_a_node_of_ros2_are_accepted() -> None:
    typed = "role camera --ros2 --ros-args -r __ns:=/r1 -r __node:=front -p rate:=5 --log-level debug -r a:=b"
    assert split_special(typed.split()) == (
        ["role", "camera", "--ros2", "_rate:=5", "a:=b"],
        {"__ns": "/r1", "__name": "front"},
    )
    typed = "serve --ros-args --params-file arm.yaml --remap __ns:=/r1 -- /dev/ttyACM0"
    assert split_special(typed.split()) == (
        ["serve", "--params-file", "arm.yaml", "/dev/ttyACM0"],
        {"__ns": "/r1"},
    )
    own = ["run", "arm", "driver.py", "--ros-args", "-r", "__ns:=/r1"]
    assert split_special(own) == (own, {})
    listing = ["launch", "arm", "arm.launch", "--ros-args"]
    assert split_special(listing) == (listing, {})

from __future__ import annotations

import asyncio
import re
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from programs import running
from rostether.cli.param import ros1_params
from rostether.cli.topic import ros1_topics
from rostether.errors import ConfigError
from rostether.serde.values import Message
from unit.cli.command_shell import STORE, LiveGraph, Shell
from unit.cli.talking import command_node, in_background, shut_down

STAMPED = ("topic", "pub", "-r", "50", "/point", "geometry_msgs/PointStamped", "{header: auto}")


class Listener:
    """Collects a topic's messages; ends the command after as many as wanted."""

    def __init__(self, graph: LiveGraph, topic: str, type_name: str, enough: int | None = None) -> None:
        self.messages: list[Message] = []
        self._codec = STORE.codec(type_name)
        message_type = STORE.registry.message_type(type_name)
        graph.do(graph.node("listener").subscribe(topic, message_type, self._take))
        if enough is not None:
            in_background(lambda: self._end(graph, enough))

    @property
    def values(self) -> list[Any]:
        return [message.data for message in self.messages]

    def _take(self, payloads: Sequence[bytes]) -> None:
        self.messages.extend(map(self._codec.decode, payloads))

    def _end(self, graph: LiveGraph, enough: int) -> None:
        graph.wait_until(lambda: len(self.messages) >= enough)
        name = command_node(graph)
        assert name is not None
        shut_down(graph, name)


Once: TypeAlias = Callable[..., str]


@pytest.fixture
def once(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> Once:
    """Publishes once; runs no longer than a subscriber on this machine needs to connect."""

    def publish_once(listener: Listener, *words: str, flag: str = "--once", stdin: str = "") -> str:
        for stay_s in (0.5, 5.0, 30.0):
            monkeypatch.setattr(ros1_topics, "ONCE_S", stay_s)
            printed = shell.output("topic", "pub", *words, flag, stdin=stdin)
            if listener.messages:
                return printed
        raise AssertionError(f"nothing was received; it printed {printed}")

    return publish_once


@pytest.fixture(autouse=True)
def _on_a_busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros1_topics, "SUBSCRIBER_TIMEOUT_S", 60.0)


def test_once(graph: LiveGraph, once: Once) -> None:
    listener = Listener(graph, "/servo", "std_msgs/UInt16")
    printed = once(listener, "servo", "std_msgs/UInt16", "90")
    assert re.fullmatch(r"publishing and latching message for [\d.]+ seconds\n", printed)
    assert set(listener.values) == {90}


def test_a_misspelt_topic_is_named(graph: LiveGraph, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros1_topics, "ONCE_S", 0.1)
    Listener(graph, "/toggle_led", "std_msgs/Empty")
    result = shell("topic", "pub", "-1", "/toggle_lde", "std_msgs/Empty")
    assert result.code == 0
    assert "no node subscribes to /toggle_lde; did you mean /toggle_led?" in result.err


def test_once_as_a_printed_book_spells_it(graph: LiveGraph, once: Once) -> None:
    listener = Listener(graph, "/toggle_led", "std_msgs/Empty")
    assert once(listener, "toggle_led", "std_msgs/Empty", flag="\N{EN DASH}once")


def test_latched_until_interrupted(graph: LiveGraph, shell: Shell) -> None:
    listener = Listener(graph, "/name", "std_msgs/String", enough=1)
    printed = shell.output("topic", "pub", "-v", "/name", "std_msgs/String", "data: hi")
    assert printed == 'publishing and latching message [data: "hi"]. Press ctrl-C to terminate\n'
    assert listener.values == ["hi"]


def test_at_a_rate(graph: LiveGraph, shell: Shell) -> None:
    listener = Listener(graph, "/cmd_vel", "geometry_msgs/Twist", enough=3)
    assert (
        shell.output("topic", "pub", "-r", "50", "/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 0.2}}")
        == ""
    )
    assert [message.linear.x for message in listener.messages[:3]] == [0.2] * 3


@pytest.mark.parametrize("arguments", [["-s"], ["-s", "--use-rostime"]])
def test_stamps_are_filled_in_each_time(graph: LiveGraph, shell: Shell, arguments: list[str]) -> None:
    listener = Listener(graph, "/point", "geometry_msgs/PointStamped", enough=3)
    shell.output(
        "topic",
        "pub",
        "-r",
        "50",
        *arguments,
        "/point",
        "geometry_msgs/PointStamped",
        "{header: auto}",
    )
    stamps = [message.header.stamp for message in listener.messages]
    assert stamps == sorted(set(stamps))


def test_without_substitution_the_first_stamp_stays(graph: LiveGraph, shell: Shell) -> None:
    listener = Listener(graph, "/point", "geometry_msgs/PointStamped", enough=3)
    shell.output(*STAMPED)
    assert len({message.header.stamp for message in listener.messages}) == 1
    first, *later = [message.header.seq for message in listener.messages]
    assert later == [first + number for number in range(1, len(later) + 1)]


def test_from_a_pipe(graph: LiveGraph, shell: Shell) -> None:
    listener = Listener(graph, "/name", "std_msgs/String")
    shell.output(
        "topic", "pub", "-r", "100", "/name", "std_msgs/String", stdin="data: a\n---\ndata: b\n---\ndata: c\n"
    )
    graph.wait_until(lambda: len(listener.messages) >= 3)
    assert listener.values == ["a", "b", "c"]


def test_messages_of_a_pipe_are_published_as_they_come(graph: LiveGraph) -> None:
    listener = Listener(graph, "/name", "std_msgs/String")
    words = ("topic", "pub", "-r", "100", "/name", "std_msgs/String")
    with running(*words, stdin=subprocess.PIPE, ROS_MASTER_URI=graph.uri) as process:
        assert process.stdin is not None
        for count, text in enumerate("abc", 1):
            process.stdin.write(f"data: {text}\n---\n")
            process.stdin.flush()
            graph.wait_until(lambda count=count: len(listener.messages) == count)  # type: ignore[misc]
    assert listener.values == ["a", "b", "c"]


def test_only_the_first_from_a_pipe(graph: LiveGraph, once: Once) -> None:
    listener = Listener(graph, "/name", "std_msgs/String")
    once(listener, "/name", "std_msgs/String", stdin="data: a\n---\ndata: b\n")
    assert set(listener.values) == {"a"}


def test_from_a_file(graph: LiveGraph, shell: Shell, tmp_path: Path) -> None:
    file = tmp_path / "names.yaml"
    file.write_text("data: a\n---\n[b]\n")
    listener = Listener(graph, "/name", "std_msgs/String")
    shell.output("topic", "pub", "-r", "100", "-f", str(file), "/name", "std_msgs/String")
    graph.wait_until(lambda: len(listener.messages) >= 2)
    assert listener.values == ["a", "b"]


def test_one_message_in_a_file_is_repeated(graph: LiveGraph, shell: Shell, tmp_path: Path) -> None:
    file = tmp_path / "name.yaml"
    file.write_text("data: a\n")
    listener = Listener(graph, "/name", "std_msgs/String", enough=3)
    printed = shell.output("topic", "pub", "-r", "50", "-f", str(file), "/name", "std_msgs/String")
    assert printed == "Got one message and a rate, publishing repeatedly\n"
    assert listener.values[:3] == ["a"] * 3


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["/a", "std_msgs/Int8", "300"], 1, "needs an int8 (-128 to 127), got 300"),
        (["/a", "std_msgs/Strin", "x"], 1, "std_msgs/Strin"),
        (["/a", "std_msgs/Int8", "{data: 1"], 1, "is not YAML"),
        (["/a b", "std_msgs/Int8", "1"], 1, "' '"),
        (["-1", "-r", "1", "/a", "std_msgs/Int8", "1"], 2, "not both"),
        (["-f", "x", "/a", "std_msgs/Int8", "1"], 2, "not both"),
        (["-f", "no_such_file", "/a", "std_msgs/Int8"], 1, "no_such_file"),
        (["-r", "0", "/a", "std_msgs/Int8", "1"], 2, "range"),
        (["/a"], 2, "TYPE"),
        (["/a", "std_msgs/UInt8", "-5"], 1, "got -5"),
        (["/a", "std_msgs/UInt8", "--", "-1"], 1, "got -1"),
        (["/a", "geometry_msgs/Point", "0", "-.5e3", "--once", "2", "3"], 1, "got 4"),
        (["-1.5", "/a", "std_msgs/UInt8"], 2, "No such option"),
    ],
)
def test_mistakes_are_reported_before_a_master_is_asked(
    shell: Shell, arguments: list[str], code: int, text: str
) -> None:
    assert text in shell.failure("topic", "pub", *arguments, code=code)


def test_an_empty_pipe_is_a_mistake(graph: LiveGraph, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros1_topics, "SUBSCRIBER_TIMEOUT_S", 0.01)
    assert "no message to publish" in shell.failure("topic", "pub", "/a", "std_msgs/Int8", stdin="")


def test_a_file_is_read_before_the_event_loop_starts(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    # In the loop, Ctrl-C would end a read from a terminal only after two seconds.
    def read(file: Path) -> str:
        with pytest.raises(RuntimeError):
            asyncio.get_running_loop()
        raise ConfigError(f"{file} was read")

    monkeypatch.setattr(ros1_params, "read_text", read)
    monkeypatch.setattr("rostether.cli.shell.input.read_text", read)
    for words in (("topic", "pub", "-f", "-", "/x", "std_msgs/String"), ("param", "load", "-")):
        assert shell.failure(*words).endswith("- was read")

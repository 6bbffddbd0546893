"""The nodes of rosbag in launch files, with the arguments of published launch files."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.recording.bag.reader import BagReader
from unit.cli.command_shell import LiveGraph
from unit.cli.launch.test_launch import TIMEOUT_S, launched
from unit.recording.bags import STRING, text, write_bag

RECORD = """<launch>
  <arg name="prefix"/>
  <node pkg="rosbag" type="record" name="keeper" ns="arm" output="screen"
        args="-o $(arg prefix) --buffsize=0 chat /old">
    <remap from="/old" to="/new"/>
  </node>
  <node pkg="rosbag" type="record" name="all" args="record -a -O $(arg prefix)_all.bag -x /rosout.*"/>
</launch>
"""
PLAY = """<launch>
  <node pkg="rosbag" type="{type}" name="player" required="true" output="screen"
        args="{verb}--clock -r 0.5 --wait-for-subscribers --topics /a --bags {bag}">
    <remap from="/a" to="/played"/>
  </node>
</launch>
"""


def _message_count(path: Path) -> int:
    try:
        reader = BagReader(path)
    except RecordingError:
        return 0  # not begun
    try:
        return sum(reader.counts.values())
    finally:
        reader.close()


def test_recording_lasts_until_the_launch_ends(graph: LiveGraph, tmp_path: Path) -> None:
    (tmp_path / "record.launch").write_text(RECORD)
    node = graph.node("/node")
    chat = graph.do(node.advertise("/arm/chat", STRING))
    new = graph.do(node.advertise("/new", STRING))
    arguments = (str(tmp_path / "record.launch"), f"prefix:={tmp_path}/drive")
    with launched(*arguments, master_uri=graph.uri, cwd=tmp_path) as process:
        graph.wait_until(lambda: (chat.subscriber_count, new.subscriber_count) == (2, 2))
        assert {"/arm/keeper", "/all"} <= set(graph.do(node.snapshot()).nodes)

        async def publish() -> None:
            chat.publish_raw([text("hello")])
            new.publish_raw([text("new")])
            await chat.drained(60)
            await new.drained(60)

        graph.do(publish())
        graph.wait_until(lambda: all(_message_count(each) == 2 for each in tmp_path.glob("*.active")))
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 130, output
    assert not list(tmp_path.glob("*.active")), output
    all_of_it = BagReader(tmp_path / "drive_all.bag")
    assert {each.topic for each in all_of_it.counts} == {"/arm/chat", "/new"}
    (named,) = tmp_path.glob("drive_2*.bag")
    found = {each.connection.topic: each.payload for each in BagReader(named).messages()}
    assert found == {"/arm/chat": text("hello"), "/new": text("new")}


@pytest.mark.parametrize(("node_type", "verb"), [("play", ""), ("rosbag", "play ")])
def test_the_launch_ends_after_a_recording_is_played(
    graph: LiveGraph, tmp_path: Path, node_type: str, verb: str
) -> None:
    bag = tmp_path / "a.bag"
    written = write_bag(bag)
    (tmp_path / "play.launch").write_text(PLAY.format(type=node_type, verb=verb, bag=bag))
    node = graph.node("/node")
    received: list[bytes] = []
    clocks: list[bytes] = []
    graph.do(node.subscribe("/played", ANY_MESSAGE, received.extend))
    graph.do(node.subscribe("/clock", ANY_MESSAGE, clocks.extend))
    arguments = (str(tmp_path / "play.launch"),)
    with launched(*arguments, master_uri=graph.uri, cwd=tmp_path) as process:
        output, _ = process.communicate(timeout=TIMEOUT_S)
    assert "played 15 messages" in output
    graph.wait_until(lambda: len(received) == 15)
    assert received == [payload for topic, _, payload in written if topic == "/a"]
    assert clocks

"""Debian's roslaunch and `rostether launch` at the same master start nodes and set parameters in the same
way.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from interop.ros1_peers import Ros1Peers
from rostether.ros1.node.master_client import MasterClient
from unit.launch.corpus import ENVIRON, FOLDER, ROBOT, given_words

LISTED = {
    "--nodes": "node_every_attribute",
    "--ros-args": "include_pass_all",
    "--files": "include_pass_all",
    "--dump-params": "arg_default_and_given",
}
OURS = (sys.executable, "-m", "rostether", "launch")
TELL = """#!/usr/bin/python3
import json, os, sys
names = ("ROS_MASTER_URI", "ROS_NAMESPACE", "MODE", "EMPTY")
said = {
    "arguments": [each for each in sys.argv[1:] if not each.startswith("__log:=")],
    "environment": {name: os.environ.get(name) for name in names},
    "folder": os.getcwd(),
    "log": [os.path.basename(each) for each in sys.argv if each.startswith("__log:=")],
}
with open(os.path.join(os.environ["TELL_INTO"], sys.argv[1]), "w") as file:
    json.dump(said, file)
"""
LAUNCH = """<launch>
  <arg name="rate" default="1"/>
  <param name="rate" value="$(arg rate)"/>
  <rosparam command="delete" param="old"/>
  <rosparam>{limits: {lower: rad(-pi/2), names: [a, b], flag: true}, text: "5"}</rosparam>
  <param name="~shared" value="s"/>
  <remap from="chatter" to="/lab/chatter"/>
  <group ns="left" clear_params="true">
    <env name="MODE" value="a b"/>
    <node name="first" pkg="teller" type="tell.py" args="first '$(arg rate) x' &quot;$(env HOME)&quot;">
      <remap from="~in" to="out"/>
      <param name="own" value="0.5"/>
    </node>
  </group>
  <node name="second" pkg="teller" type="tell.py" args="second" cwd="node"/>
  <node name="third" pkg="teller" type="tell.py" args="third" launch-prefix="env EMPTY="/>
</launch>
"""


@pytest.fixture
def teller(tmp_path: Path) -> Path:
    folder = tmp_path / "packages" / "teller"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>teller</name></package>")
    (folder / "tell.launch").write_text(LAUNCH)
    (folder / "tell.py").write_text(TELL)
    (folder / "tell.py").chmod(0o755)
    return folder


def environment(peers: Ros1Peers, packages: Path, reported: Path) -> None:
    peers.environment.update(ENVIRON, ROS_PACKAGE_PATH=f"{packages}:/usr/share", TELL_INTO=str(reported))


async def parameters(master_uri: str) -> Any:
    client = MasterClient(master_uri, "/test")
    try:
        tree: Any = await client.get_param("/")
    finally:
        await client.close()
    return {key: value for key, value in tree.items() if key not in ("run_id", "roslaunch")}


async def run_both(peers: Ros1Peers, tmp_path: Path, *words: str) -> list[tuple[Any, Any]]:
    """Run the same launch with both; return the reports of the nodes and the parameters of each."""
    results = []
    for name, command in (("theirs", ("roslaunch",)), ("ours", OURS)):
        reported = tmp_path / name
        reported.mkdir()
        environment(peers, tmp_path / "packages", reported)
        client = MasterClient(peers.master_uri, "/test")
        await client.set_param("/old", 1)
        await client.set_param("/left/gone", 1)
        await client.close()
        await peers.run(*command, *words)
        output = {file.name: json.loads(file.read_text()) for file in sorted(reported.iterdir())}
        results.append((output, await parameters(peers.master_uri)))
    return results


async def test_nodes_and_parameters_are_those_of_roslaunch(
    roscore: Ros1Peers, teller: Path, tmp_path: Path
) -> None:
    (theirs, their_parameters), (ours, our_parameters) = await run_both(
        roscore, tmp_path, "teller", "tell.launch", "rate:=2.5"
    )
    assert set(theirs) == {"first", "second", "third"}
    assert ours == theirs
    assert our_parameters == their_parameters
    assert our_parameters["left"] == {"first": {"own": 0.5, "shared": "s"}}
    assert "old" not in our_parameters


@pytest.mark.parametrize(("option", "name"), LISTED.items())
async def test_listing_is_that_of_roslaunch(name: str, option: str, tmp_path: Path) -> None:
    peers = Ros1Peers("http://localhost:9", tmp_path)
    environment(peers, FOLDER, tmp_path)
    words = ("corpus_robot", f"{name}.launch", option, *given_words(ROBOT / "launch" / f"{name}.launch"))
    try:
        theirs, ours = await asyncio.gather(peers.run("roslaunch", *words), peers.run(*OURS, *words))
    finally:
        await peers.close()
    if option == "--dump-params":
        assert yaml.safe_load(ours) == yaml.safe_load(theirs)
    elif option == "--files":
        assert sorted(ours.split()) == sorted(theirs.split())
    else:
        assert ours == theirs


async def test_rospy_node_of_debian_is_launched_and_stopped(roscore: Ros1Peers, tmp_path: Path) -> None:
    folder = tmp_path / "packages" / "speaker"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>speaker</name></package>")
    (folder / "speak.launch").write_text(
        '<launch><node name="speaker" pkg="speaker" type="speak.py" ns="lab" output="screen">'
        '<param name="word" value="hello"/><remap from="said" to="/heard"/></node></launch>'
    )
    (folder / "speak.py").write_text(
        "#!/usr/bin/python3\nimport rospy\nfrom std_msgs.msg import String\nrospy.init_node('x')\n"
        "out = rospy.Publisher('said', String, latch=True, queue_size=1)\n"
        "out.publish(rospy.get_param('~word') + rospy.get_name())\n"
        "rospy.on_shutdown(lambda: print('goodbye', flush=True))\nrospy.spin()\n"
    )
    (folder / "speak.py").chmod(0o755)
    environment(roscore, tmp_path / "packages", tmp_path)
    launch = await roscore.start(*OURS, "speaker", "speak.launch")
    assert 'data: "hello/lab/speaker"' in await roscore.run("rostopic", "echo", "-n", "1", "/heard")
    os.kill(launch.process.pid, 2)
    assert "goodbye" in await launch.finish()
    assert launch.process.returncode == 130

"""Debian's roslaunch and `rostether launch` at the same master start nodes and set parameters in the same
way.
"""

from __future__ import annotations

import asyncio
import json
import os
from pathlib import Path
from typing import Any

import pytest
import yaml

from interop.ros1_peers import Ros1Peers
from programs import ROSTETHER
from rostether.ros1.node.master_client import MasterClient
from unit.launch.corpus import ENVIRON, FOLDER, ROBOT, given_words

LISTED = {
    "--nodes": "node_every_attribute",
    "--ros-args": "include_pass_all",
    "--files": "include_pass_all",
    "--dump-params": "arg_default_and_given",
}
LAUNCH_COMMAND = (*ROSTETHER, "launch")
REPORTER = """#!/usr/bin/python3
import json, os, sys
names = ("ROS_MASTER_URI", "ROS_NAMESPACE", "MODE", "EMPTY")
found = {
    "arguments": [each for each in sys.argv[1:] if not each.startswith("__log:=")],
    "environment": {name: os.environ.get(name) for name in names},
    "folder": os.getcwd(),
    "log": [os.path.basename(each) for each in sys.argv if each.startswith("__log:=")],
}
with open(os.path.join(os.environ["REPORT_FOLDER"], sys.argv[1]), "w") as file:
    json.dump(found, file)
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
    <node name="first" pkg="reporter" type="report.py" args="first '$(arg rate) x' &quot;$(env HOME)&quot;">
      <remap from="~in" to="out"/>
      <param name="own" value="0.5"/>
    </node>
  </group>
  <node name="second" pkg="reporter" type="report.py" args="second" cwd="node"/>
  <node name="third" pkg="reporter" type="report.py" args="third" launch-prefix="env EMPTY="/>
</launch>
"""


@pytest.fixture
def reporter(tmp_path: Path) -> Path:
    folder = tmp_path / "packages" / "reporter"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>reporter</name></package>")
    (folder / "report.launch").write_text(LAUNCH)
    (folder / "report.py").write_text(REPORTER)
    (folder / "report.py").chmod(0o755)
    return folder


def environment(peers: Ros1Peers, packages: Path, reported: Path) -> None:
    peers.environment.update(ENVIRON, ROS_PACKAGE_PATH=f"{packages}:/usr/share", REPORT_FOLDER=str(reported))


async def parameters(master_uri: str) -> Any:
    client = MasterClient(master_uri, "/test")
    try:
        tree: Any = await client.get_param("/")
    finally:
        await client.close()
    return {key: value for key, value in tree.items() if key not in ("run_id", "roslaunch")}


async def run_both(peers: Ros1Peers, tmp_path: Path, *arguments: str) -> list[tuple[Any, Any]]:
    """Run the same launch with both; return the reports of the nodes and the parameters of each."""
    results = []
    for name, command in (("debian", ("roslaunch",)), ("rostether", LAUNCH_COMMAND)):
        reported = tmp_path / name
        reported.mkdir()
        environment(peers, tmp_path / "packages", reported)
        client = MasterClient(peers.master_uri, "/test")
        await client.set_param("/old", 1)
        await client.set_param("/left/gone", 1)
        await client.close()
        await peers.run(*command, *arguments)
        output = {file.name: json.loads(file.read_text()) for file in sorted(reported.iterdir())}
        results.append((output, await parameters(peers.master_uri)))
    return results


async def test_nodes_and_parameters_are_those_of_roslaunch(
    roscore: Ros1Peers, reporter: Path, tmp_path: Path
) -> None:
    (debian, debian_parameters), (rostether, rostether_parameters) = await run_both(
        roscore, tmp_path, "reporter", "report.launch", "rate:=2.5"
    )
    assert set(debian) == {"first", "second", "third"}
    assert rostether == debian
    assert rostether_parameters == debian_parameters
    assert rostether_parameters["left"] == {"first": {"own": 0.5, "shared": "s"}}
    assert "old" not in rostether_parameters


@pytest.mark.parametrize(("option", "name"), LISTED.items())
async def test_listing_is_that_of_roslaunch(name: str, option: str, tmp_path: Path) -> None:
    peers = Ros1Peers("http://localhost:9", tmp_path)
    environment(peers, FOLDER, tmp_path)
    arguments = ("corpus_robot", f"{name}.launch", option, *given_words(ROBOT / "launch" / f"{name}.launch"))
    try:
        debian, rostether = await asyncio.gather(
            peers.run("roslaunch", *arguments), peers.run(*LAUNCH_COMMAND, *arguments)
        )
    finally:
        await peers.close()
    if option == "--dump-params":
        assert yaml.safe_load(rostether) == yaml.safe_load(debian)
    elif option == "--files":
        assert sorted(rostether.split()) == sorted(debian.split())
    else:
        assert rostether == debian


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
    launch = await roscore.start(*LAUNCH_COMMAND, "speaker", "speak.launch")
    assert 'data: "hello/lab/speaker"' in await roscore.run("rostopic", "echo", "-n", "1", "/heard")
    os.kill(launch.process.pid, 2)
    assert "goodbye" in await launch.finish()
    assert launch.process.returncode == 130

"""The same scripts with Debian's rospy and with rostether's: their output, and their state in the graph."""

from __future__ import annotations

import asyncio
import json
import re
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from interop.ros1_peers import DEBIAN_PYTHON, Ros1Peers
from programs import Peer
from rostether.rospy.actionlib.comm_states import TRANSITIONS
from rostether.rospy.environment import script_environment
from unit.recording.bags import write_bag

SCRIPTS = Path(__file__).parent / "rospy_scripts"
PYTHONS = [DEBIAN_PYTHON, sys.executable]
REMAPPINGS = ["early:=/talk/moved", "_gain:=2.5", "__name:=mona", "__ns:=/lisa", "answer:=renamed", "x"]


async def start(peers: Ros1Peers, python: str, script: str, *arguments: str) -> Peer:
    """Start a script; the Python of the tests has rostether's rospy."""
    peers.environment = script_environment(peers.environment)
    return await peers.start(python, str(SCRIPTS / script), *arguments)


async def printed(peers: Ros1Peers, python: str, script: str, *arguments: str) -> list[str]:
    """Return the standard output of a script, without rospy's debug messages and without times."""
    process = await asyncio.create_subprocess_exec(
        python,
        str(SCRIPTS / script),
        *arguments,
        env=script_environment(peers.environment),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        out, err = await asyncio.wait_for(process.communicate(), 120)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    if python == DEBIAN_PYTHON and b"a goal handle that we're not tracking" in err:
        # Debian's action client may receive a goal's status before it has stored the goal, and then waits
        # forever.
        return await printed(peers, python, script, *arguments)
    if python == DEBIAN_PYTHON and b"Unable to avoid copy while creating an array" in err:
        pytest.skip("Debian's tf.transformations does not work with NumPy 2")
    assert process.returncode == 0, err.decode()
    lines = out.decode().splitlines()
    return [re.sub(r"\[\d+\.\d+\]", "[time]", line) for line in lines if not _is_ignored(line)]


def _is_ignored(line: str) -> bool:
    # Debian's rospy reports a probe of its services, depending on when the probe ends.
    probed = "incoming connection failed" in line or "transport terminated" in line
    return _is_debug(line) or probed


def _is_debug(line: str) -> bool:
    return line.startswith("[DEBUG]") and not line.endswith(("debug 1", "last"))


async def observe(peers: Ros1Peers, python: str, end: str, *arguments: str) -> dict[str, Any]:
    """Return the report of Debian's observer about a talker, and the exit code of the talker."""
    name = "/lisa/mona" if arguments else "/talker"
    talker = await start(peers, python, "talker.py", *arguments)
    observer = await start(peers, DEBIAN_PYTHON, "observer.py", name)
    await observer.wait_for("READY")
    if end == "kill":
        await peers.run("rosnode", "kill", name)
    else:
        talker.process.send_signal(getattr(signal, end))
    await talker.finish()
    await observer.finish()
    last_line = observer.lines[-1]
    assert last_line.startswith("LEFT"), observer.text
    # Debian's rospy may close its connections before it has sent the message of its shutdown hook.
    assert python == DEBIAN_PYTHON or last_line == "LEFT with a message"
    found: dict[str, Any] = json.loads(next(line for line in observer.lines if line.startswith("FOUND"))[6:])
    found["exit"] = talker.process.returncode
    found["printed"] = [re.sub(r"\d+\.\d+", "time", line) for line in talker.lines if "tick" in line]
    return found


async def test_values(roscore: Ros1Peers) -> None:
    debian, rostether = await asyncio.gather(*(printed(roscore, python, "values.py") for python in PYTHONS))
    assert rostether == debian
    assert len(rostether) > 150


@pytest.mark.robot
@pytest.mark.parametrize("script", ["filters.py", "tools.py"])
async def test_modules_beside_rospy(roscore: Ros1Peers, script: str) -> None:
    debian = await printed(roscore, DEBIAN_PYTHON, script)
    rostether = await printed(roscore, sys.executable, script)
    assert rostether == debian
    assert len(rostether) > 10


@pytest.mark.parametrize("script", ["clouds.py", "lookups.py", "matrices.py", "packages.py"])
async def test_modules_of_messages_and_tools(roscore: Ros1Peers, script: str) -> None:
    debian = await printed(roscore, DEBIAN_PYTHON, script)
    rostether = await printed(roscore, sys.executable, script)
    assert rostether == debian
    assert len(rostether) > 10


@pytest.mark.robot
async def test_frames(roscore: Ros1Peers) -> None:
    debian = await printed(roscore, DEBIAN_PYTHON, "frames.py")
    rostether = await printed(roscore, sys.executable, "frames.py")
    assert rostether == debian
    assert len(rostether) > 200


@pytest.mark.robot
async def test_the_buffer_of_another_node(roscore: Ros1Peers) -> None:
    await roscore.start("/usr/lib/tf2_ros/buffer_server")
    debian = await printed(roscore, DEBIAN_PYTHON, "buffer_client.py")
    rostether = await printed(roscore, sys.executable, "buffer_client.py")
    assert rostether == debian
    assert rostether[0] == "True"
    assert len(rostether) > 6


async def test_a_node_with_its_own_topics_and_services(roscore: Ros1Peers) -> None:
    arguments = ("chatter:=/talk/other", "_rate:=5", "_name:=karl", "__ns:=/robot", "number:=renamed")
    debian = await printed(roscore, DEBIAN_PYTHON, "node_api.py", *arguments)
    rostether = await printed(roscore, sys.executable, "node_api.py", *arguments)
    assert rostether == debian
    assert len(rostether) > 70


@pytest.mark.parametrize(
    ("end", "arguments"), [("SIGINT", []), ("SIGTERM", REMAPPINGS), ("kill", REMAPPINGS)]
)
async def test_an_observer_receives_the_same(roscore: Ros1Peers, end: str, arguments: list[str]) -> None:
    debian = await observe(roscore, DEBIAN_PYTHON, end, *arguments)
    rostether = await observe(roscore, sys.executable, end, *arguments)
    if end == "kill":
        # Debian's loop may publish when the publisher is closed; it then ends with 1.
        debian["exit"] = 0
    assert rostether == debian
    assert len(rostether["registered"][0]) == 6


async def test_each_action_client_works_with_each_server(roscore: Ros1Peers) -> None:
    """Every client with every server: the client has the same results."""
    seen = []
    for server_python, name in ((DEBIAN_PYTHON, "debian"), (sys.executable, "rostether")):
        server = await start(roscore, server_python, "action_server.py", f"__name:={name}")
        await server.wait_for("SERVING")
        for python in PYTHONS:
            seen.append(await printed(roscore, python, "action_client.py", f"/{name}"))
        server.process.send_signal(signal.SIGINT)
        await server.finish()
    assert seen[1:] == [seen[0]] * 3
    assert len(seen[0]) > 30


async def test_bags(roscore: Ros1Peers, tmp_path: Path) -> None:
    bag = tmp_path / "input.bag"
    write_bag(bag, count=6)
    arguments = [(python, str(tmp_path / f"{number}.bag"), str(bag)) for number, python in enumerate(PYTHONS)]
    debian, rostether = await asyncio.gather(
        *(printed(roscore, python, "bags.py", *script_arguments) for python, *script_arguments in arguments)
    )
    assert rostether == debian
    assert len(rostether) > 130


async def test_the_states_of_goals(roscore: Ros1Peers) -> None:
    script = """
import json
from actionlib import action_client
ways = {}
for state, by_status in action_client._transitions.items():
    for status, way in by_status.items():
        if way != action_client.INVALID_TRANSITION:
            way = [] if way == action_client.NO_TRANSITION else way
            ways.setdefault(state, {})[status] = way if isinstance(way, (list, tuple)) else [way]
print(json.dumps(ways, sort_keys=True))
"""
    debian = json.loads(await roscore.run(DEBIAN_PYTHON, "-c", script))
    rostether = {
        str(state): {str(status): list(states) for status, states in by_status.items()}
        for state, by_status in TRANSITIONS.items()
    }
    assert rostether == debian


async def test_arguments_of_functions(roscore: Ros1Peers) -> None:
    reference, own = [
        json.loads("".join(await printed(roscore, python, "signatures.py"))) for python in PYTHONS
    ]
    # These need what only a real rospy has; a later genpy has renamed the argument of `deserialize`.
    different = {"anonymous_name", "deserialize", "Manifest", "publish_message", "ROSBagFormatException"}
    different |= {"ServerGoalHandle", "strify_message", "Topic"}
    compared = 0
    for name in reference.keys() & own.keys():
        wanted, found = reference[name], own[name]
        if wanted is None or found is None or name.rpartition(".")[2] in different:
            continue
        compared += 1
        # Further arguments are optional.
        assert [each.rstrip("=") for each in found[: len(wanted)]] == [each.rstrip("=") for each in wanted], (
            name
        )
        assert all(each.endswith("=") for each in found[len(wanted) :]), name
    assert compared > 500

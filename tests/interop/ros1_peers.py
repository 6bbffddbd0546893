"""Debian's ROS 1: its tools, its Python nodes and a compiled roscpp node.

All of them run as subprocesses with a separate environment, on loopback, and are ended by process
group when the test ends.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import hashlib
import os
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

from children import MARK
from programs import TIMEOUT_S, Peer, start_program
from rostether.errors import GraphError
from rostether.ros1.node.master_client import MasterClient

DEBIAN_PYTHON = "/usr/bin/python3"
ROBOT_PROGRAMS = {
    "/usr/lib/robot_state_publisher/robot_state_publisher": "ros-robot-state-publisher",
    "/usr/lib/joint_state_publisher/joint_state_publisher": "joint-state-publisher",
    "/usr/lib/tf2_ros/static_transform_publisher": "tf2-tools",
    "/usr/bin/check_urdf": "liburdfdom-tools",
}
# Above well-known ports (11311, 11411), below those that the system assigns.
_FIRST_PORT = 12_000
_PORTS_EACH = 1_000
# The number of test processes for which there are enough ports.
MAX_WORKERS = 20
_GIVEN_PORTS: set[int] = set()
ROSOUT = "/usr/lib/rosout/rosout"
CORE_PARAMETERS = {
    "/run_id": "4df0c52c-e59c-11f1-8b3a-02fc00000001",
    "/rosdistro": "noetic\n",
    "/rosversion": "1.15.15\n",
}
PEER_SOURCE = Path(__file__).parent / "peers" / "roscpp_peer.cpp"


def missing_ros1() -> str:
    """Return why Debian's ROS 1 tools cannot be used here, or an empty string."""
    if shutil.which("rostopic", path="/usr/bin") is None:
        return "Debian's ROS 1 is not installed (apt install ros-core python3-rospy)"
    probe = subprocess.run(
        [DEBIAN_PYTHON, "-c", "import rospy, sensor_msgs.msg"], capture_output=True, check=False
    )
    return "" if probe.returncode == 0 else "/usr/bin/python3 cannot import rospy and sensor_msgs"


def debian_python_version() -> tuple[int, ...]:
    """Return the version of the Python that Debian's ROS 1 uses, such as (3, 11)."""
    version = subprocess.run([DEBIAN_PYTHON, "-V"], capture_output=True, text=True, check=True)
    return tuple(map(int, version.stdout.split()[1].split(".")[:2]))


def missing_roscpp() -> str:
    """Return why a roscpp node cannot be built here, or an empty string."""
    if shutil.which("g++") is None:
        return "no C++ compiler (apt install g++)"
    if not Path("/usr/include/ros/ros.h").exists() or not Path("/usr/include/std_srvs/SetBool.h").exists():
        return "roscpp's headers are not installed (apt install libroscpp-dev libstd-srvs-dev)"
    return ""


def missing_robot() -> str:
    """Return why Debian's tf2 and robot nodes cannot be used here, or an empty string."""
    for program, package in ROBOT_PROGRAMS.items():
        if not Path(program).exists():
            return f"no {program} (apt install {package})"
    probe = subprocess.run([DEBIAN_PYTHON, "-c", "import tf2_ros, PyKDL"], capture_output=True, check=False)
    return (
        ""
        if probe.returncode == 0
        else "/usr/bin/python3 cannot import tf2_ros and PyKDL (python3-tf2-ros python3-pykdl)"
    )


def free_port() -> int:
    """Return a free TCP port that no other test gets before it is used.

    It is below the ports that the system assigns to connections and to listeners on port 0. Only the
    other test processes use such ports, each a different range.
    """
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")) % MAX_WORKERS
    while True:
        port = _FIRST_PORT + secrets.randbelow(_PORTS_EACH) * MAX_WORKERS + worker
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("", port))
            if port not in _GIVEN_PORTS:
                _GIVEN_PORTS.add(port)
                return port


def roscpp_peer() -> Path:
    """Return the compiled roscpp peer, built once for all test processes."""
    digest = hashlib.sha256(PEER_SOURCE.read_bytes()).hexdigest()[:16]
    folder = Path(tempfile.gettempdir()) / f"rostether-peers-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    program = folder / f"roscpp_peer-{digest}"
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not program.exists():
            flags = subprocess.run(
                ["pkg-config", "--cflags", "--libs", "roscpp"], capture_output=True, text=True, check=True
            ).stdout.split()
            unfinished = program.with_suffix(".new")
            command = ["g++", "-O1", "-o", str(unfinished), str(PEER_SOURCE), *flags, "-lpthread"]
            subprocess.run(command, check=True)
            unfinished.rename(program)
    return program


def ros_environment(master_uri: str, home: Path) -> dict[str, str]:
    """Return the environment of Debian's tools, without rostether and the user's settings."""
    return {
        # Not set when a benchmark uses this.
        MARK: os.environ.get(MARK, ""),
        "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
        "HOME": str(home),
        "ROS_HOME": str(home / ".ros"),
        "ROS_LOG_DIR": str(home / "log"),
        "ROS_MASTER_URI": master_uri,
        "ROS_HOSTNAME": "localhost",
        "ROS_PACKAGE_PATH": "/usr/share",
        "ROS_ROOT": "/usr/share/ros",
        "ROS_ETC_DIR": "/etc/ros",
        "ROS_OS_OVERRIDE": "debian",
        "ROS_DISTRO": "noetic",
        "PYTHONUNBUFFERED": "1",
        "LANG": "C.UTF-8",
    }


class Ros1Peers:
    """Starts Debian's ROS 1 programs against one master."""

    def __init__(self, master_uri: str, home: Path) -> None:
        self.master_uri = master_uri
        self.environment = ros_environment(master_uri, home)
        self._peers: list[Peer] = []

    async def start(self, *command: str, stdin: bytes | None = None, keeps_stdin: bool = False) -> Peer:
        """Start a program: `rostopic`, a path, or `python` for Debian's Python.

        With `keeps_stdin` more may be written to it later.
        """
        program = DEBIAN_PYTHON if command[0] == "python" else command[0]
        peer = await start_program(
            program, *command[1:], environment=self.environment, has_stdin=stdin is not None
        )
        if stdin is not None and peer.process.stdin is not None:
            peer.process.stdin.write(stdin)
            if not keeps_stdin:
                peer.process.stdin.close()
        self._peers.append(peer)
        return peer

    async def run(self, *command: str, timeout_s: float = TIMEOUT_S, check: bool = True) -> str:
        """Run a program to its end and return its output; fail if its exit code is not 0."""
        peer = await self.start(*command)
        text = await peer.finish(timeout_s)
        if check and peer.process.returncode != 0:
            raise AssertionError(f"{' '.join(command)} ended with {peer.process.returncode}:\n{text}")
        return text

    async def rospy(self, script: str, *arguments: str) -> Peer:
        """Start a rospy script given as text."""
        return await self.start("python", "-c", script, *arguments)

    async def roscpp(self, role: str, *arguments: str) -> Peer:
        """Start the compiled roscpp peer in a role (its source lists them)."""
        program = await asyncio.to_thread(roscpp_peer)
        return await self.start(str(program), role, *arguments)

    async def close(self) -> None:
        """Kill every program that still runs."""
        await asyncio.gather(*(peer.stop(signal.SIGKILL) for peer in self._peers))


@contextlib.asynccontextmanager
async def debian_roscore(home: Path) -> AsyncIterator[Ros1Peers]:
    """Run the programs of Debian's roscore on a free port, without the slower roslaunch."""
    port = free_port()
    peers = Ros1Peers(f"http://localhost:{port}/", home)
    master = MasterClient(peers.master_uri, "/roslaunch")
    try:
        await peers.start("rosmaster", "--core", "-p", str(port))
        async with asyncio.timeout(TIMEOUT_S):
            while not await _answers(master):
                await asyncio.sleep(0.01)
            for name, value in CORE_PARAMETERS.items():
                await master.set_param(name, value)
            await peers.start(ROSOUT, "__name:=rosout")
            while "/rosout_agg" not in (await master.system_state())[0]:
                await asyncio.sleep(0.01)
        yield peers
    finally:
        await master.close()
        await peers.close()


async def _answers(master: MasterClient) -> bool:
    with contextlib.suppress(GraphError):
        return await master.get_pid() > 0
    return False

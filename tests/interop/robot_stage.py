"""A robot's node, Debian's or rostether's, with Debian's roscore: joint states in, tf out."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from interop.ros1_peers import Ros1Peers
from programs import Peer
from rostether.ros1.node.master_client import MasterClient

RECORDER = Path(__file__).parent / "peers" / "robot_recorder.py"
LIBRARIES = "/usr/lib"
ROLES = {
    "robot_state_publisher": "robot-state-publisher",
    "joint_state_publisher": "joint-state-publisher",
    "tf2_ros": "static-transform-publisher",
}
PROGRAMS = {"tf2_ros": "static_transform_publisher"}


class RobotStage:
    """Starts nodes and a recorder; `side` is `debian` or `rostether`."""

    def __init__(self, peers: Ros1Peers) -> None:
        self._peers = peers
        self._recorder: Peer | None = None

    async def set_params(self, parameters: Mapping[str, Any]) -> None:
        """Set parameters at the master."""
        master = MasterClient(self._peers.master_uri, "/setter")
        for name, value in parameters.items():
            await master.set_param(name, value)
        await master.close()

    async def start_node(self, side: str, package: str, *arguments: str) -> Peer:
        """Start a package's node of `side`."""
        if side == "debian":
            program = PROGRAMS.get(package, package)
            return await self._peers.start(f"{LIBRARIES}/{package}/{program}", *arguments)
        role = ROLES[package]
        return await self._peers.start(sys.executable, "-P", "-m", "rostether", "role", role, *arguments)

    async def start_recorder(self, topic: str = "/joint_states") -> None:
        """Record /tf, /tf_static and /joint_states_out from now on; `publish` publishes on `topic`."""
        self._recorder = await self._peers.start(
            "python", "-u", str(RECORDER), topic, stdin=b"", keeps_stdin=True
        )
        await self._recorder.wait_for('"ready"')

    async def stop_recorder(self) -> None:
        """Kill the recorder, so that the next one starts without records. A shutdown of rospy would take 0.6
        s.
        """
        assert self._recorder is not None
        await self._recorder.stop(signal.SIGKILL)

    @property
    def records(self) -> list[dict[str, Any]]:
        """Return the records so far."""
        assert self._recorder is not None
        found = (json.loads(line) for line in self._recorder.lines if line.startswith("{"))
        return [record for record in found if "topic" in record]

    async def wait_for(self, condition: Callable[[list[dict[str, Any]]], bool]) -> None:
        """Wait until the records meet a condition."""
        assert self._recorder is not None
        await self._recorder.wait_for(lambda _: condition(self.records))

    async def wait_for_subscribers(self, count: int) -> None:
        """Wait until `count` nodes subscribe to the joint states."""
        self._send({"wait_for": count})
        assert self._recorder is not None
        await self._recorder.wait_for('"connected"')

    def publish(self, stamp_ns: int, names: Sequence[str], positions: Sequence[float]) -> None:
        """Publish a joint state."""
        self._send({"stamp_ns": stamp_ns, "name": list(names), "position": list(positions)})

    def _send(self, record: Mapping[str, Any]) -> None:
        assert self._recorder is not None
        stdin = self._recorder.process.stdin
        assert stdin is not None
        stdin.write(json.dumps(record).encode() + b"\n")

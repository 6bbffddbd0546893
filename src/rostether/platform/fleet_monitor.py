"""The node fleet_monitor: publishes the state of each robot that answers, and stops robots on request.

fleet       (sensing_platform/Fleet, latched)
fleet_stop  (sensing_platform/StopRobots: the id of a robot, 0 for all)
"""

from __future__ import annotations

import asyncio
import math
import time
from contextlib import closing

from msgspec.structs import replace

from rostether.graph.ports import Level, Report
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.block_end import closed_at_end
from rostether.platform.fleet import FleetSender, FleetSettings, has_stopped
from rostether.platform.robot_table import Robot, RobotKey
from rostether.rostime import Time
from rostether.serde.values import Message

# Fast enough for a display, and slow enough for the Wi-Fi of a large fleet.
_QUERY_PERIOD_S = 0.5

# Bad Wi-Fi rarely loses all queries and answers in this time.
LOST_S = 3.0


class FleetMonitor:
    """The node fleet_monitor; `run` serves until canceled. Its queries command nothing."""

    def __init__(self, graph: TypedGraph, settings: FleetSettings, report: Report) -> None:
        self._graph = graph
        self._settings = settings
        self._report = report
        self._lost: set[RobotKey] = set()
        self._stopping = asyncio.Lock()

    async def run(self) -> None:
        """Publish until canceled. Raises ConfigError, GraphError."""
        graph, stop = self._graph, self._stop
        with closing(FleetSender(self._settings, self._report)) as queries:
            fleet = await graph.publisher("fleet", "sensing_platform/Fleet", latch=True)
            async with (
                closed_at_end(fleet),
                closed_at_end(await graph.service_server("fleet_stop", "sensing_platform/StopRobots", stop)),
            ):
                self._report(Level.INFO, f"asking the robots at {self._settings.address} for their state")
                while True:
                    await queries.query(_QUERY_PERIOD_S, _QUERY_PERIOD_S)
                    fleet.publish(robots=self._states(queries.robots, time.monotonic()))

    async def _stop(self, request: Message) -> dict[str, list[int]]:
        # One stop at a time: a second sender would make the robots refuse the first.
        async with self._stopping:
            sender = self._settings.sender
            if request.robot:
                sender = replace(sender, target=request.robot, to_groups=False)
            with closing(FleetSender(replace(self._settings, sender=sender), self._report)) as stop:
                robots = await stop.stop()
        confirmed = sorted({robot.status.robot_id for robot in robots if has_stopped(robot)})
        who = f"robot {request.robot}" if request.robot else "all robots"
        self._report(Level.INFO, f"stop sent to {who}; {len(confirmed)} confirmed it")
        return {"confirmed": confirmed}

    def _states(self, robots: list[Robot], now_s: float) -> list[dict[str, object]]:
        """Return the robots; a robot that changed its address is not reported as lost at the old one."""
        lost = {robot.key for robot in robots if now_s - robot.answered_s > LOST_S}
        here = {robot.status.robot_id for robot in robots if robot.key not in lost}
        for robot_id, host in sorted(lost - self._lost):
            if robot_id not in here:
                self._report(
                    Level.WARN,
                    f"robot {robot_id} ({host}) has not answered for {LOST_S:g} s; check its network",
                )
        for robot_id, host in sorted(self._lost - lost):
            self._report(Level.INFO, f"robot {robot_id} ({host}) answers again")
        self._lost = lost
        graph_now_ns = self._graph.now().to_ns()
        return [
            _state(robot, robot.key in lost, graph_now_ns - int((now_s - robot.answered_s) * 1e9))
            for robot in robots
            if robot.key not in lost or robot.status.robot_id not in here
        ]


def _state(robot: Robot, is_lost: bool, answered_ns: int) -> dict[str, object]:
    status = robot.status
    return {
        "id": status.robot_id,
        "address": robot.address[0],
        "state": "lost" if is_lost else "moving" if status.is_moving else "stopped",
        "commanded_by": "" if is_lost else status.holder,
        "loss": math.nan if robot.loss is None else robot.loss,
        "signal_dbm": status.signal_dbm or 0,
        "uses_unicast": robot.needs_unicast,
        "answered": Time.from_ns(max(0, answered_ns)),
    }

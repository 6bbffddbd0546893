"""Nodes of a ROS 2 graph over zenoh, in a thread with its own event loop."""

from __future__ import annotations

import asyncio

from contract.zenoh_graphs import open_session
from interop.ros1_peers import free_port
from rostether.msgdef.registry import Registry
from rostether.ros2.zenoh.node import ZenohGraph
from rostether.serde.store import TypeStore
from unit.cli.command_shell import GraphThread

STORE = TypeStore(Registry())
REPEAT_S = 0.05


class ZenohWorld(GraphThread):
    """A router with a node `/far/board`, which has a publisher, a subscriber, a service and parameters."""

    def __init__(self) -> None:
        super().__init__()
        self.received: list[bytes] = []
        self.port = free_port()
        self.session = self.do(open_session(self.port, is_router=True))
        self.board: ZenohGraph = self.do(self.session.join("/far/board"))
        self._publishing = self.do(self._populate())

    def stop(self, task: asyncio.Task[None]) -> None:
        """Cancel a task of the thread."""
        self._loop.call_soon_threadsafe(task.cancel)

    def close(self) -> None:
        """End the board, the router and the thread."""
        self.stop(self._publishing)
        self.do(self.session.close())
        super().close()

    async def _populate(self) -> asyncio.Task[None]:
        registry, board = STORE.registry, self.board
        imu = await board.advertise("/imu", registry.message_type("sensor_msgs/Imu"))
        name = await board.advertise("/name", registry.message_type("std_msgs/String"), latch=True)
        hidden = await board.advertise("/_raw", registry.message_type("std_msgs/String"))
        twist = registry.message_type("geometry_msgs/Twist")
        await board.subscribe("/cmd_vel", twist, self.received.extend)
        pose = registry.message_type("geometry_msgs/Pose")
        await board.subscribe("/goal", pose, self.received.extend)

        async def answer(request: bytes) -> bytes:
            is_on = STORE.codec("std_srvs/SetBoolRequest").decode(request).data
            fields = {"success": is_on, "message": "it is on" if is_on else ""}
            return STORE.codec("std_srvs/SetBoolResponse").encode(fields)

        await board.advertise_service("/set_led", registry.service_type("std_srvs/SetBool"), answer)
        await board.set_param("~gain", 1.5)
        await board.set_param("~arm/joints", [1, 2])
        imu_payload = STORE.codec("sensor_msgs/Imu").encode(
            {
                "header": {"frame_id": "base", "stamp": {"secs": 5, "nsecs": 7}},
                "angular_velocity": {"z": 0.5},
            }
        )
        string = STORE.codec("std_msgs/String")
        name.publish_raw([string.encode({"data": "arm"})])

        async def keep_publishing() -> None:
            while True:
                imu.publish_raw([imu_payload])
                hidden.publish_raw([string.encode({"data": "x" * 200})])
                await asyncio.sleep(REPEAT_S)

        return asyncio.get_running_loop().create_task(keep_publishing())

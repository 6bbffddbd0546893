"""Nodes of a ROS 2 graph over zenoh, in a thread with its own event loop."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from contract.zenoh_graphs import open_session
from interop.ros1_peers import free_port
from rostether.msgdef.registry import Registry
from rostether.ros2.zenoh.node import ZenohGraph
from rostether.serde.store import TypeStore

T = TypeVar("T")

STORE = TypeStore(Registry())
REPEAT_S = 0.05


class ZenohWorld:
    """A router with a node `/far/board`, which has a publisher, a subscriber, a service and parameters."""

    def __init__(self) -> None:
        self.received: list[bytes] = []
        self.port = free_port()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self.session = self.do(open_session(self.port, is_router=True))
        self.board: ZenohGraph = self.do(self.session.join("/far/board"))
        self._publishing = self.do(self._populate())

    def do(self, work: Coroutine[Any, Any, T]) -> T:
        """Run a coroutine in the thread and wait for its result."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(60)

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until something has become true in the thread."""
        deadline_s = time.monotonic() + 60
        while not condition():
            assert time.monotonic() < deadline_s, "it never became true"
            time.sleep(0.002)

    def stop(self, task: asyncio.Task[None]) -> None:
        """Cancel what runs in the thread."""
        self._loop.call_soon_threadsafe(task.cancel)

    def close(self) -> None:
        """End everything."""
        self._loop.call_soon_threadsafe(self._publishing.cancel)
        self.do(self.session.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(60)
        self._loop.close()

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

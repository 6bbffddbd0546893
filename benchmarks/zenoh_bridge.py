"""A bridge into ROS 2 over zenoh, like `serve --ros2 zenoh`, on ports that only this benchmark uses.

zenoh_bridge.py DEVICE_PORT ZENOH_PORT NAME   prints a line when boards can connect, ends with its stdin
"""

from __future__ import annotations

import asyncio
import gc
import sys

from rostether.bridge.supervisor import Supervisor
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.types.type_support import Ros2Types
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach
from rostether.serde.store import TypeStore
from rostether.transports.address_parser import parse_address


async def serve(device_port: str, zenoh_port: str, name: str) -> None:
    """Serve until the standard input is closed."""
    registry = Registry()
    environment = Ros2Environment(zenoh_overrides=(("listen/endpoints", f'["tcp/127.0.0.1:{zenoh_port}"]'),))
    types = Ros2Types(registry, Ros2Definitions())
    session = await ZenohSession.open(environment, types, reach=ZenohReach(RouterChoice.ALWAYS))
    supervisor = Supervisor(session.join, TypeStore(registry))
    await supervisor.start([parse_address(f"tcp://127.0.0.1:{device_port}?name={name}")])
    gc.freeze()
    print("serving", flush=True)
    await asyncio.to_thread(sys.stdin.read)
    await supervisor.close()
    await session.close()


if __name__ == "__main__":
    asyncio.run(serve(*sys.argv[1:]))

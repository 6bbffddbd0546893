"""`rostether core --ros2 zenoh`: the zenoh router of this machine, instead of rmw_zenohd."""

from __future__ import annotations

import asyncio
from dataclasses import replace

from rostether.cli.access.graph_options import ZenohReach
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.access.ros_choice import Middleware
from rostether.cli.shell.output import write_line

_USUAL_PLACES = ("/localhost:7447", "/127.0.0.1:7447", "/[::1]:7447", "/0.0.0.0:7447", "/[::]:7447")


async def serve_router(reach: ZenohReach) -> None:
    """Run the router until cancelled. Raises ConfigError, MasterUnreachableError if another one runs."""
    async with ros2_access(Middleware.ZENOH, reach=replace(reach, router="always")) as access:
        from rostether.ros2.zenoh.reachability import is_loopback

        write_line("Started a zenoh router for RMW_IMPLEMENTATION=rmw_zenoh_cpp")
        if access.connects_to:
            write_line(
                f"Connecting to other routers when they are available: {', '.join(access.connects_to)}"
            )
        others = [endpoint for endpoint in access.listens_on if not is_loopback(endpoint)]
        if others:
            write_line(f"Other machines can reach it at {', '.join(others)}")
        else:
            write_line(
                "Only this machine can reach it; add --zenoh-listen tcp/0.0.0.0:7447 for other machines"
            )
        if not any(endpoint.endswith(_USUAL_PLACES) for endpoint in access.listens_on):
            write_line(
                "Nodes on this machine use tcp/localhost:7447: add --zenoh-listen tcp/localhost:7447 for them"
            )
        write_line("Press Ctrl-C to stop")
        await asyncio.Event().wait()

"""`rostether core`: the ROS master alone, or the zenoh router of ROS 2."""

from __future__ import annotations

import asyncio

import click

from rostether.cli.access.graph_options import GraphOptions, Middleware, graph_options, ros2_option
from rostether.cli.access.options import listen_option
from rostether.cli.access.ros1_access import read_environment
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.access.served_graphs import master_answers
from rostether.cli.bridge.options import GRAPH_LIMITS, limit_option, read_graph_limits
from rostether.cli.shell.option_group import add_option, ignored_options
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import GraphError
from rostether.mechanisms.block_end import closed_at_end
from rostether.ros1.environment import format_uri
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

# Nodes on this machine find the router only if one of its endpoints ends with one of these texts.
_USUAL_ENDPOINTS = ("/localhost:7447", "/127.0.0.1:7447", "/[::1]:7447", "/0.0.0.0:7447", "/[::]:7447")

# Scripts pass these options of roscore; they have no effect here.
_roscore_options = ignored_options(
    "-w --numworkers",
    "-t --timeout",
    "--master-logger-level",
    "--sigint-timeout",
    "--sigterm-timeout",
    flags=["-v"],
)


@verb(
    "core",
    """
    rostether core                        the master at http://localhost:11311
    rostether core --port 11312           another port, for a second graph
    rostether core --listen 0.0.0.0       for nodes on other machines too
    rostether core --ros2 zenoh --zenoh-listen tcp/0.0.0.0:7447
    """,
    is_service=True,
)
@add_option(
    "-p --port",
    "The master's port (default: that of ROS_MASTER_URI, or 11311); 0 for any free port.",
    type=click.IntRange(0, 65535),
)
@listen_option
@limit_option(GRAPH_LIMITS)
@ros2_option("Run a ROS 2 zenoh router instead.", "[zenoh]")
@graph_options(served=True, master=False, ros=False, zenoh=True)
@_roscore_options
async def core(
    port: int | None, listen: str | None, limits: tuple[str, ...], ros2: str | None, graph: GraphOptions
) -> None:
    """Run the ROS master, parameter server and log collector, like roscore.

    With --ros2 zenoh, run the zenoh router of this machine, like rmw_zenohd. It listens on localhost:7447, or
    only at the --zenoh-listen endpoints.
    """
    # Without --ros2, run the ROS 1 master even if ROS 2 is sourced: ROS 2 has no master.
    if ros2 is not None:
        if ros2 == Middleware.RCLPY:
            raise click.UsageError(
                "only ROS 2 over zenoh needs a router; with DDS, nodes discover each other"
            )
        if port is not None or listen is not None or graph.allow or limits:
            raise click.UsageError("with --ros2, the router accepts only --zenoh-connect and --zenoh-listen")
        await _serve_router(graph.zenoh)
        return
    graph.refuse_unused()
    from rostether.ros1.roscore import Roscore

    environment = read_environment(graph, listen).limited(read_graph_limits(limits))
    port = environment.master.port if port is None else port
    try:
        roscore = await Roscore.start(environment, port=port)
    except GraphError:
        there = environment.with_master(format_uri("localhost", port))
        if not await master_answers(there):
            raise
        raise GraphError(
            f"a ROS master already runs at {there.master_uri}; use it, or choose another port with --port"
        ) from None
    async with closed_at_end(roscore):
        write_line(f"ROS_MASTER_URI={roscore.uri}")
        if environment.listens_on_loopback_only:
            write_line("Only this machine can reach it; add --listen 0.0.0.0 for other machines")
        write_line("Press Ctrl-C to stop")
        await roscore.wait_closed()


async def _serve_router(reach: ZenohReach) -> None:
    """Run the router until canceled. Raises ConfigError, MasterUnreachableError if another one runs."""
    async with ros2_access(Middleware.ZENOH, reach=reach._replace(router=RouterChoice.ALWAYS)) as access:
        from rostether.ros2.zenoh.reachability import is_local

        write_line("Started a zenoh router for RMW_IMPLEMENTATION=rmw_zenoh_cpp")
        if access.connects_to:
            write_line(
                f"Connecting to other routers when they are available: {', '.join(access.connects_to)}"
            )
        others = [endpoint for endpoint in access.listens_on if not is_local(endpoint)]
        if others:
            write_line(f"Other machines can reach it at {', '.join(others)}")
        else:
            write_line(
                "Only this machine can reach it; add --zenoh-listen tcp/0.0.0.0:7447 for other machines"
            )
        if not any(endpoint.endswith(_USUAL_ENDPOINTS) for endpoint in access.listens_on):
            write_line(
                "Nodes on this machine use tcp/localhost:7447: add --zenoh-listen tcp/localhost:7447 for them"
            )
        write_line("Press Ctrl-C to stop")
        await asyncio.Event().wait()

"""`rostether doctor --ros2`: reports whether the ROS 2 graph can be reached, and why not."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from rostether.cli.access.graph_options import GraphOptions, Middleware, middleware_of
from rostether.cli.access.ros2_tool_node import tool_node
from rostether.cli.shell.output import write_finding
from rostether.errors import RostetherError
from rostether.mechanisms.text import counted
from rostether.names.graph_name import is_hidden
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.rclpy.left_over_memory import SHARED_MEMORY, find_leftover_files

# Reports whether something works, what it is, and what was found.
_Report: TypeAlias = Callable[[bool, str, str], None]


async def examine_ros2(ros2: str, *, as_json: bool) -> bool:
    """Print the findings; return whether none is a problem. Raises ConfigError."""
    results: list[bool] = []

    def report(is_ok: bool, what: str, text: str) -> None:
        results.append(is_ok)
        write_finding(what, text, is_ok=is_ok, as_json=as_json)

    await _examine(middleware_of(ros2), report)
    return all(results)


async def _examine(middleware: Middleware, report: _Report) -> None:
    if middleware is Middleware.ZENOH:
        await _examine_routers(Ros2Environment.read(), report)
    elif left := find_leftover_files():
        # Checked first, because leftover files can also delay the join below.
        text = (
            f"killed programs have left {counted(len(left), 'file')}, such as {left[0]}; if programs hang at "
            "their start, stop all ROS 2 programs and run `rm -f /dev/shm/*fastdds* /dev/shm/*fastrtps*`"
        )
        report(True, f"shared memory of Fast DDS in {SHARED_MEMORY}", text)
    try:
        async with tool_node(GraphOptions(ros2=middleware), is_quiet=True, needs_definitions=False) as tool:
            nodes = {node for node in (await tool.settled_snapshot()).nodes if not is_hidden(node)}
            text = f"{counted(len(nodes), 'node')} found. {tool.line}"
    except RostetherError as error:
        report(False, "graph", str(error))
    else:
        report(True, "graph", text)


async def _examine_routers(environment: Ros2Environment, report: _Report) -> None:
    """Try the router of this machine, and every endpoint that the configuration files name."""
    # zenoh may be missing; `ros2_access` reports that.
    try:
        from rostether.ros2.zenoh.access_check import find_denied_topics
        from rostether.ros2.zenoh.configuration import (
            ROUTER_ENDPOINT,
            configures_endpoints,
            peer_configuration,
            router_configuration,
        )
        from rostether.ros2.zenoh.reachability import (
            NO_SESSION,
            endpoints_of,
            find_fault,
            find_listen_fault,
            tls_of,
        )
        from rostether.ros2.zenoh_reach import ZenohReach
    except ModuleNotFoundError:
        return
    if not configures_endpoints(environment):
        fault = await find_fault(ROUTER_ENDPOINT, {})
        advice = f"{fault} Start one with `rostether core --ros2 zenoh`, or with ROS 2's rmw_zenohd"
        report(not fault, f"router of this machine, {ROUTER_ENDPOINT}", advice if fault else "answers")
    for path, configure in (
        (environment.zenoh_router_config, router_configuration),
        (environment.zenoh_session_config, peer_configuration),
    ):
        if path is None:
            continue
        configuration = configure(environment, ZenohReach())
        tls = tls_of(configuration)
        for endpoint in endpoints_of(configuration, "connect"):
            fault = await find_fault(endpoint, tls)
            denied = () if fault else await find_denied_topics(configuration, endpoint, environment.domain_id)
            if denied is None:
                fault = NO_SESSION
            elif denied:
                fault = f"its access control denies {', '.join(denied)} to this machine"
            report(not fault, f"{endpoint} in {path}", fault or "answers")
        listening = endpoints_of(configuration, "listen")
        if listening:
            fault = find_listen_fault(configuration)
            where = f"listens on {', '.join(listening)}"
            report(not fault, str(path), f"{where}, but {fault}" if fault else where)

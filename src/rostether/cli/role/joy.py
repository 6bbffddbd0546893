"""joy_node as a role."""

from __future__ import annotations

from rostether.cli.role.node import reporter, role
from rostether.graph.node_parameters import NodeParameters
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments
from rostether.nodes.joy import DEFAULT_DEVICE, JoySettings, device_named, publish_joystick


@role(
    "joy-node",
    """
    rostether role joy-node
    rostether role joy-node _dev:=/dev/input/js1 _deadzone:=0.1 _autorepeat_rate:=20
    """,
)
async def joy_node(graph: TypedGraph, _: Arguments) -> None:
    """Publish a joystick as sensor_msgs/Joy on `joy`, like joy_node.

    Parameters: ~dev (/dev/input/js0), ~dev_name, ~deadzone (0.05), ~autorepeat_rate (0), ~coalesce_interval
    (0.001), ~sticky_buttons, ~default_trig_val.
    """
    report = reporter(graph)
    device = str(await graph.get_param("~dev", DEFAULT_DEVICE))
    if name := str(await graph.get_param("~dev_name", "")):
        found = device_named(name)
        if found is None:
            report(Level.ERROR, f"no joystick has the name {name!r}; using {device}")
        device = found or device
    parameters = NodeParameters(graph)
    settings = JoySettings(
        device=device,
        deadzone=await parameters.number(0.05, "deadzone"),
        autorepeat_rate_hz=await parameters.number(0.0, "autorepeat_rate"),
        coalesce_interval_s=await parameters.number(0.001, "coalesce_interval"),
        sticky_buttons=bool(await graph.get_param("~sticky_buttons", False)),
        default_trig_val=bool(await graph.get_param("~default_trig_val", False)),
    )
    await publish_joystick(graph, settings, report)

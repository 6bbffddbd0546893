"""The camera's node as a role."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import ROS2_CHOICE
from rostether.cli.platform.sensor_roles import sensor_node_name
from rostether.cli.role.node import RoleVerb, node_arguments, node_words, reporter, run_role
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.graph.node_parameters import NodeParameters
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments
from rostether.platform.sensor_parameters import SensorKind, default_platform, read_description

if TYPE_CHECKING:
    from rostether.platform.sensors.cascade import CascadeDetector
    from rostether.platform.sensors.picture_sources import PictureSource

# In pixels. The pictures of robots' cameras are smaller.
_MAX_SIDE = 8192


@verb(
    "camera",
    """
    rostether role camera
    rostether role camera _source:=/dev/video2 _id:=front _vflip:=true _width:=640 _height:=480
    rostether role camera _source:=pictures _rate:=2
    rostether role camera _classifier:=haarcascade_frontalface_default.xml
    rostether role camera _source:=test
    """,
    cls=RoleVerb,
)
@node_words
@ROS2_CHOICE
def camera(arguments: tuple[str, ...], ros2: str | None) -> None:
    """Publish a camera as a sensor (sensor_msgs/CompressedImage), only while a program shows it.

    Parameters: ~source (/dev/video0, or picamera2 where it is installed; a folder of .jpg files; test),
    ~vflip, ~hflip, ~width, ~height, ~quality (1 to 95), ~rate (10 Hz), ~id (camera), ~name, ~platform_name,
    ~frame_id, ~classifier (a cascade file of OpenCV: draws boxes around what it finds, and publishes them on
    <topic>/detections).
    """
    name = sensor_node_name("camera", node_arguments(arguments))
    run_role(name, arguments, partial(_camera, ros2 is None), ros2)


async def _camera(is_ros1: bool, graph: TypedGraph, _: Arguments) -> None:
    from rostether.platform.sensors.camera import MESSAGE_TYPE, publish_pictures

    parameters = NodeParameters(graph, "camera/")
    original = await _original_parameters(graph, parameters) if is_ros1 else {}
    source = await _source(parameters, bool(original.get("vflip")), bool(original.get("hflip")))
    description = await read_description(parameters, SensorKind("camera", "CAMERA", MESSAGE_TYPE, 10.0))
    # Some versions of the platform's original camera node misspell the parameter.
    original_file = original.get("classifier") or original.get("clasifier") or ""
    file = await parameters.text(str(original_file), "classifier")
    detector = await asyncio.to_thread(_detector, file) if file else None
    await publish_pictures(graph, description, source, reporter(graph), detector)


def _detector(file: str) -> CascadeDetector:
    from rostether.platform.sensors.cascade import CascadeDetector

    return CascadeDetector(Path(file).expanduser())


async def _original_parameters(graph: TypedGraph, parameters: NodeParameters) -> Mapping[str, ParamValue]:
    """Return the parameters of the platform's original camera node, such as Robot3-pi_camera/vflip."""
    key = f"{await parameters.text(default_platform(), 'platform_name')}-pi_camera"
    # The hyphen is not allowed in names, so only the whole tree can be requested.
    if not any(name.startswith(f"/{key}/") for name in await graph.raw.list_params()):
        return {}
    tree = await graph.raw.get_param("/")
    found = tree.get(key) if isinstance(tree, dict) else None
    return found if isinstance(found, dict) else {}


async def _source(parameters: NodeParameters, vflip: bool, hflip: bool) -> PictureSource:
    from rostether.platform.sensors.jpeg import PictureChange
    from rostether.platform.sensors.picture_sources import DrawnTestPictures, PictureFolder
    from rostether.platform.sensors.raspberry_camera import RaspberryCamera, has_picamera2
    from rostether.platform.sensors.v4l2_camera import V4l2Camera

    change = PictureChange(
        vflip=await parameters.flag(vflip, "vflip"),
        hflip=await parameters.flag(hflip, "hflip"),
        width=await parameters.integer(0, 0, _MAX_SIDE, "width"),
        height=await parameters.integer(0, 0, _MAX_SIDE, "height"),
        quality=await parameters.integer(0, 0, 95, "quality"),
    )
    if bool(change.width) != bool(change.height):
        raise ConfigError("give both ~width and ~height")
    name = await parameters.text("picamera2" if has_picamera2() else "/dev/video0", "source")
    if name == "test":
        return DrawnTestPictures(change)
    if name == "picamera2":
        return RaspberryCamera(change)
    path = await asyncio.to_thread(Path(name).expanduser)
    is_folder = await asyncio.to_thread(path.is_dir)
    return PictureFolder(path, change) if is_folder else V4l2Camera(path, change)

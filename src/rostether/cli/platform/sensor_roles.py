"""The sensors' nodes as roles: analog, digital, gps, battery, system_load and camera."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable, Mapping
from functools import partial
from pathlib import Path

from msgspec.structs import replace

from rostether.cli.access.graph_options import ROS2_CHOICE
from rostether.cli.role.node import RoleVerb, node_arguments, node_words, reporter, role, run_role
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.graph.node_parameters import NodeParameters
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments
from rostether.platform.sensor_parameters import SensorKind, default_platform, read_description, read_rate
from rostether.platform.sensors.cascade import CascadeDetector
from rostether.platform.sensors.gpio_line import BIASES, GpioLine, gpio_package
from rostether.platform.sensors.jpeg import PictureChange
from rostether.platform.sensors.number_file import NumberFile
from rostether.platform.sensors.picture_sources import DrawnTestPictures, PictureFolder, PictureSource
from rostether.platform.sensors.raspberry_camera import RaspberryCamera, has_picamera2
from rostether.platform.sensors.registered_sensor import platform_word
from rostether.platform.sensors.system_load import SystemFiles, publish_system_load
from rostether.platform.sensors.v4l2_camera import V4l2Camera
from rostether.platform.sensors.value import Scaling, TopicField, publish_values
from rostether.transports.address import SerialAddress
from rostether.transports.address_parser import parse_address

# In pixels. The pictures of robots' cameras are smaller.
_MAX_SIDE = 8192


def sensor_node_name(word: str, arguments: Arguments) -> str:
    """Return the name of a sensor's node; it begins with the robot's name: robots may share a graph."""
    given = arguments.private_params
    platform = str(given.get("platform_name") or default_platform())
    return f"{platform_word(platform)}_{platform_word(str(given.get('id', word)))}"


_sensor = partial(role, has_ros2=True, node_name=sensor_node_name)


@_sensor(
    "analog",
    """
    rostether role analog _id:=voltage _path:=/sys/bus/iio/devices/iio:device0/in_voltage0_raw _scale:=11
    rostether role analog _id:=distance _topic:=/arm/ultrasound _field:=range _unit:=m _alert_below:=0.1
    """,
)
async def analog(graph: TypedGraph, _: Arguments) -> None:
    """Publish a number from a file of the system, or from a field of a topic, as a sensor.

    Parameters: ~path (a file with a number; those in /sys/bus/iio get their unit), or ~topic and ~field
    (data); ~scale (1), ~offset (0), ~alert_below, ~alert_above, ~rate (10 Hz, for a file), ~unit,
    ~id (analog), ~name, ~platform_name, ~frame_id.
    """
    await _publish_value("analog", graph)


@_sensor(
    "digital",
    """
    rostether role digital _id:=bumper _gpio:=GPIO17 _bias:=pull_up _active_low:=true
    rostether role digital _id:=button _topic:=/arm/button
    """,
)
async def digital(graph: TypedGraph, _: Arguments) -> None:
    """Publish 1 or 0 from a GPIO line, a file, or a field of a topic, as a sensor.

    Parameters: ~gpio (number or name of a line), ~chip (/dev/gpiochip0), ~bias (as_is, disabled, pull_up,
    pull_down), ~active_low; or ~path; or ~topic and ~field (data); ~id (digital), ~name, ~platform_name.
    """
    await _publish_value("digital", graph)


@_sensor(
    "gps",
    """
    rostether role gps _port:=/dev/ttyACM0
    rostether role gps "_port:=/dev/ttyUSB0?baud=9600" _frame_id:=gps
    rostether role gps "_port:=tcp://192.168.1.7:11123?connect=yes"
    """,
)
async def gps(graph: TypedGraph, _: Arguments) -> None:
    """Publish the positions of a receiver that sends NMEA, as a sensor (sensor_msgs/NavSatFix).

    Parameters: ~port (/dev/ttyACM0; a link address), ~baud (9600), ~frame_id (gps), ~id (gps), ~name,
    ~platform_name.
    """
    from rostether.platform.sensors.gps import MESSAGE_TYPE, publish_positions

    parameters = NodeParameters(graph, "gps/")
    address = parse_address(await parameters.text("/dev/ttyACM0", "port"))
    if isinstance(address, SerialAddress) and "baud" not in address.given:
        address = replace(address, baud=await parameters.integer(9600, 300, 4_000_000, "baud"))
    description = await read_description(parameters, SensorKind("gps", "GPS", MESSAGE_TYPE, 1.0))
    description = replace(description, frame_id=description.frame_id or "gps")
    await publish_positions(graph, description, address, reporter(graph))


@_sensor("battery", "rostether role battery _alert_below:=0.2")
async def battery(graph: TypedGraph, _: Arguments) -> None:
    """Publish this computer's battery as a sensor (sensor_msgs/BatteryState).

    Parameters: ~path (the first battery in /sys/class/power_supply), ~alert_below (0.15), ~rate (0.5 Hz),
    ~id (battery), ~name, ~platform_name.
    """
    from rostether.platform.sensors.battery import MESSAGE_TYPE, publish_battery

    parameters = NodeParameters(graph, "battery/")
    path = await parameters.text("", "path")
    description = await read_description(parameters, SensorKind("battery", "BATTERY", MESSAGE_TYPE, 0.5))
    alert_below = await parameters.number(0.15, "alert_below")
    await publish_battery(graph, description, Path(path) if path else None, alert_below, reporter(graph))


@_sensor("system-load", "rostether role system-load _rate:=0.2")
async def system_load(graph: TypedGraph, _: Arguments) -> None:
    """Publish this computer's load as sensors: cpu, memory and disk in percent, and its temperature.

    Parameters: ~rate (0.5 Hz), ~disk (a folder on the disk; /), ~platform_name.
    """
    parameters = NodeParameters(graph, "system_load/")
    platform = await parameters.text(default_platform(), "platform_name")
    files = SystemFiles(disk=Path(await parameters.text("/", "disk")))
    rate_hz = await read_rate(parameters, 0.5)
    await publish_system_load(graph, platform, platform_word(platform), rate_hz, files, reporter(graph))


async def _publish_value(word: str, graph: TypedGraph) -> None:
    from rostether.platform.sensors.value import MESSAGE_TYPE

    parameters = NodeParameters(graph, f"{word}/")
    open_source, unit, silence = await _value_source(graph, parameters, word)
    kind = SensorKind(word, word.upper(), MESSAGE_TYPE, 10.0, unit)
    scaling = Scaling(
        await parameters.number(1.0, "scale"),
        await parameters.number(0.0, "offset"),
        await parameters.number(float("-inf"), "alert_below"),
        await parameters.number(float("inf"), "alert_above"),
    )
    description = await read_description(parameters, kind)
    await publish_values(graph, description, open_source, scaling, reporter(graph), silence=silence)


async def _value_source(
    graph: TypedGraph, parameters: NodeParameters, word: str
) -> tuple[Callable[[], AsyncGenerator[float, None]], str, str]:
    """Return a function that opens the source of values, their unit, and the text to show without values.

    The parameters select the source. Raises ConfigError.
    """
    path = await parameters.text("", "path")
    topic = await parameters.text("", "topic")
    line = await parameters.text("", "gpio")
    if sum(map(bool, (path, topic, line))) != 1 or (line and word == "analog"):
        choices = "~path or ~topic" if word == "analog" else "~gpio, ~path or ~topic"
        raise ConfigError(f"give one of {choices}, for instance _topic:=/arm/ultrasound _field:=range")
    if path:
        file = NumberFile(Path(path))
        rate_hz = await read_rate(parameters, 10.0)
        return lambda: file.readings(rate_hz), file.unit, ""
    if topic:
        field = await parameters.text("data", "field")
        source = TopicField(graph, topic, field)
        return source.values, "", source.silence
    gpio_package()
    bias = await parameters.text("as_is", "bias")
    if bias not in BIASES:
        raise ConfigError(f"~bias must be one of {', '.join(BIASES)}, not {bias!r:.100}")
    gpio = GpioLine(
        line,
        await parameters.text("/dev/gpiochip0", "chip"),
        bias,
        await parameters.flag(False, "active_low"),
    )
    return gpio.levels, "", ""


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
async def camera(arguments: tuple[str, ...], ros2: str | None) -> None:
    """Publish a camera as a sensor (sensor_msgs/CompressedImage), only while a program shows it.

    Parameters: ~source (/dev/video0, or picamera2 where it is installed; a folder of .jpg files; test),
    ~vflip, ~hflip, ~width, ~height, ~quality (1 to 95), ~rate (10 Hz), ~id (camera), ~name, ~platform_name,
    ~frame_id, ~classifier (a cascade file of OpenCV: draws boxes around what it finds, and publishes them on
    <topic>/detections).
    """
    name = sensor_node_name("camera", node_arguments(arguments))
    await run_role(name, arguments, partial(_camera, ros2 is None), ros2)


async def _camera(is_ros1: bool, graph: TypedGraph, _: Arguments) -> None:
    from rostether.platform.sensors.camera import MESSAGE_TYPE, publish_pictures

    parameters = NodeParameters(graph, "camera/")
    original = await _original_parameters(graph, parameters) if is_ros1 else {}
    source = await _source(parameters, bool(original.get("vflip")), bool(original.get("hflip")))
    description = await read_description(parameters, SensorKind("camera", "CAMERA", MESSAGE_TYPE, 10.0))
    # Some versions of the platform's original camera node misspell the parameter.
    original_file = original.get("classifier") or original.get("clasifier") or ""
    file = await parameters.text(str(original_file), "classifier")
    detector = await asyncio.to_thread(lambda: CascadeDetector(Path(file).expanduser())) if file else None
    await publish_pictures(graph, description, source, reporter(graph), detector)


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

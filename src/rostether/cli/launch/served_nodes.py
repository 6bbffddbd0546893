"""The nodes that launch files and rosrun name, and that are ours by role: (package, type) -> our command.

A row is the words behind `rostether`. Such a command takes what any ROS node takes: `__name:=`, `__ns:=`,
`_parameter:=value`, `from:=to`. What shows itself in a window of its own stands in `_WINDOWS`: the user's own
is started when installed, else one line says what takes its place.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from rostether.packages.executables import library_folders

_SERIAL = ("serial-node",)

SERVED_NODES: dict[tuple[str, str], tuple[str, ...]] = {
    ("rosserial_python", "serial_node.py"): _SERIAL,
    ("rosserial_python", "serial_node"): _SERIAL,
    ("rosserial_arduino", "serial_node.py"): _SERIAL,
    ("rosserial_server", "serial_node"): ("role", "rosserial-server-serial"),
    ("rosserial_server", "socket_node"): ("role", "rosserial-server-socket"),
    ("rosserial_server", "udp_socket_node"): ("role", "rosserial-server-udp"),
    ("rosserial_arduino", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_client", "make_libraries"): ("role", "make-libraries"),
    ("rosserial_client", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_embeddedlinux", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_mbed", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_windows", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_tivac", "make_libraries_energia"): ("role", "make-libraries"),
    ("rosserial_tivac", "make_libraries_tiva"): ("role", "make-libraries"),
    ("robot_state_publisher", "robot_state_publisher"): ("role", "robot-state-publisher"),
    ("robot_state_publisher", "state_publisher"): ("role", "robot-state-publisher"),
    ("joint_state_publisher", "joint_state_publisher"): ("role", "joint-state-publisher"),
    ("joint_state_publisher_gui", "joint_state_publisher_gui"): ("role", "joint-state-publisher-gui"),
    ("tf", "static_transform_publisher"): ("role", "tf-static-transform-publisher"),
    ("tf2_ros", "static_transform_publisher"): ("role", "static-transform-publisher"),
    ("tf", "tf_echo"): ("tf", "echo"),
    ("tf2_ros", "echo.py"): ("tf", "echo"),
    ("tf", "tf_monitor"): ("tf", "monitor"),
    ("tf2_ros", "tf2_monitor"): ("tf", "monitor"),
    ("tf", "view_frames"): ("tf", "tree"),
    ("tf2_tools", "view_frames.py"): ("tf", "tree"),
    ("rqt_tf_tree", "rqt_tf_tree"): ("tf", "tree"),
    ("xacro", "xacro"): ("xacro",),
    ("xacro", "xacro.py"): ("xacro",),
    ("rosbag", "record"): ("bag", "record"),
    ("rosbag", "play"): ("bag", "play"),
    ("rosbag", "rosbag"): ("bag",),
    ("foxglove_bridge", "foxglove_bridge"): ("role", "foxglove-bridge"),
    ("rosbridge_server", "rosbridge_websocket"): ("role", "rosbridge-websocket"),
    ("rosbridge_server", "rosbridge_websocket.py"): ("role", "rosbridge-websocket"),
    ("rosapi", "rosapi_node"): ("role", "rosapi-node"),
    ("tf2_web_republisher", "tf2_web_republisher"): ("role", "tf2-web-republisher"),
    ("joy", "joy_node"): ("role", "joy-node"),
    ("arduino_control", "arduino_control"): ("role", "arduino-control"),
    ("bridge", "multicast_topic_bridge"): ("role", "multicast-topic-bridge"),
    ("bridge", "multicast_topic_receiver"): ("role", "multicast-topic-receiver"),
    ("sensors", "sensing_manager.py"): ("role", "sensing-manager"),
    ("sensors", "sensing_manager"): ("role", "sensing-manager"),
    ("sensors", "digital_tester.py"): ("role", "digital-tester"),
    ("sensors", "digital_tester"): ("role", "digital-tester"),
    ("topic_tools", "relay"): ("role", "relay"),
    ("topic_tools", "throttle"): ("role", "throttle"),
    ("topic_tools", "mux"): ("role", "mux"),
    ("topic_tools", "mux_select"): ("role", "mux-select"),
    ("topic_tools", "mux_add"): ("role", "mux-add"),
    ("topic_tools", "mux_delete"): ("role", "mux-delete"),
    ("topic_tools", "mux_list"): ("role", "mux-list"),
}

# The part of the dashboard that replaces a window.
_WINDOWS = {
    "rviz": "the robot in 3D",
    "rviz2": "the robot in 3D",
    "rqt_graph": "nodes and topics",
    "rqt_plot": "values over time",
    "rqt_image_view": "pictures",
    "rqt_gui": "plots, pictures, logs and 3D",
    "rqt_console": "logs",
    "rqt_topic": "topics and their messages",
    "rqt_publisher": "topics and publishes on them",
    "rqt_service_caller": "services and calls them",
    "rqt_reconfigure": "parameters and sets them",
    "rqt_robot_steering": "a joystick that drives the robot",
}

# In a terminal these show the same at once.
_TERMINAL_VIEWS = {"rqt_graph": ("graph",), "rqt_plot": ("role", "rqt-plot")}

# Built-in programs that launch files run for a parameter's value: `$(find xacro)/xacro`.
_PROGRAMS = {("xacro", "xacro"): ("xacro",)}


def served_nodes() -> dict[tuple[str, str], list[str]]:
    """Map (package, type) of the nodes that we serve to whole command lines, without the node's arguments."""
    return {node: our_command(*words) for node, words in SERVED_NODES.items() if _exists(words)}


def our_command(*words: str) -> list[str]:
    """Return the command line of one of our verbs, run by this very Python."""
    # Without -P, a file in the current folder could replace one of rostether's modules.
    return [sys.executable, "-P", "-m", "rostether", *words]


def replacement_line(package: str, environ: Mapping[str, str], *, in_terminal: bool = False) -> str | None:
    """Return what takes the place of an rviz or rqt program that is not installed; None for others."""
    if package not in _WINDOWS and not package.startswith("rqt_"):
        return None
    if window_program(package, package, environ) is not None:
        return None
    shown = _WINDOWS.get(package, "the robot")
    if in_terminal and package in _TERMINAL_VIEWS:
        return f"{package} is not installed here; `rostether {package.removeprefix('rqt_')}` shows {shown}"
    return f"{package} is not installed here; the dashboard shows {shown}"


def view_command(package: str, arguments: Sequence[str]) -> list[str]:
    """Return our command line that shows what a window of rviz or rqt would, given its arguments."""
    if package in _TERMINAL_VIEWS:
        names = [each for each in arguments if ":=" not in each and not each.startswith("-")]
        return our_command(*_TERMINAL_VIEWS[package], *names)
    # A window's own options, such as rviz's `-d FILE`, mean nothing here.
    return our_command("dashboard", *(each for each in arguments if ":=" in each and each[0] != "-"))


def window_program(package: str, name: str, environ: Mapping[str, str]) -> Path | None:
    """Return the user's own rviz or rqt program, None where it is not installed."""
    for library in library_folders(package, None, environ):
        if os.access(library / name, os.X_OK) and (library / name).is_file():
            return library / name
    from rostether.cli.launch.shims import is_shim

    for part in environ.get("PATH", os.defpath).split(os.pathsep):
        found = shutil.which(name, path=part) if part else None
        # Our own shim would only come back to us.
        if found is not None and not is_shim(Path(found)):
            return Path(found)
    return None


def _exists(words: tuple[str, ...]) -> bool:
    from rostether.cli.role.group import ROLES
    from rostether.cli.verb_table import VERBS

    return words[1] in ROLES if words[0] == "role" else words[0] in VERBS


def served_programs() -> dict[tuple[str, str], list[str]]:
    """Map (package, program) to whole command lines, without the program's arguments."""
    return {program: our_command(*words) for program, words in _PROGRAMS.items()}

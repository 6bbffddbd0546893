"""The built-in nodes of launch files and rosrun: maps (package, type) to a rostether command.

`BUILTIN_NODES` has the words after `rostether`. The command accepts all arguments of ROS nodes: `__name:=`,
`__ns:=`, `_parameter:=value`, `from:=to`. `_WINDOWS` has the programs with windows: a panel of the
dashboard replaces a program that is not installed.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from rostether.cli.shell.own_command import own_command
from rostether.packages.executables import library_folders

_SERIAL = ("serial-node",)

BUILTIN_NODES: dict[tuple[str, str], tuple[str, ...]] = {
    ("rosserial_python", "serial_node.py"): _SERIAL,
    ("rosserial_python", "serial_node"): _SERIAL,
    ("rosserial_arduino", "serial_node.py"): _SERIAL,
    ("rosserial_server", "serial_node"): ("role", "rosserial-server-serial"),
    ("rosserial_server", "socket_node"): ("role", "rosserial-server-socket"),
    ("rosserial_server", "udp_socket_node"): ("role", "rosserial-server-udp"),
    ("rosserial_server", "rosserial_server_socket_node"): ("role", "rosserial-server-socket"),
    ("rosserial_server", "rosserial_server_serial_node"): ("role", "rosserial-server-serial"),
    ("rosserial_python", "message_info_service.py"): ("role", "message-info-service"),
    ("rosserial_xbee", "setup_xbee.py"): ("xbee", "setup"),
    ("rosserial_xbee", "xbee_network.py"): ("role", "xbee-network"),
    ("rosserial_arduino", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_client", "make_libraries"): ("role", "make-libraries"),
    ("rosserial_client", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_client", "make_library.py"): ("role", "make-libraries"),
    ("rosserial_embeddedlinux", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_mbed", "make_libraries.py"): ("role", "make-libraries"),
    ("rosserial_stm32", "make_libraries.py"): ("role", "make-libraries"),
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
    ("sensors", "pi_camera.py"): ("role", "camera"),
    ("sensors", "pi_camera"): ("role", "camera"),
    ("sensors", "camera"): ("role", "camera"),
    ("sensors", "analog"): ("role", "analog"),
    ("sensors", "digital"): ("role", "digital"),
    ("sensors", "gps"): ("role", "gps"),
    ("sensors", "battery"): ("role", "battery"),
    ("sensors", "system_load"): ("role", "system-load"),
    ("topic_tools", "relay"): ("role", "relay"),
    ("topic_tools", "throttle"): ("role", "throttle"),
    ("topic_tools", "mux"): ("role", "mux"),
    ("topic_tools", "mux_select"): ("role", "mux-select"),
    ("topic_tools", "mux_add"): ("role", "mux-add"),
    ("topic_tools", "mux_delete"): ("role", "mux-delete"),
    ("topic_tools", "mux_list"): ("role", "mux-list"),
}

# The panel of the dashboard that replaces a window, and its contents; an empty one is the overview.
_WINDOWS = {
    "rviz": ("scene", "the robot in 3D"),
    "rviz2": ("scene", "the robot in 3D"),
    "rqt_graph": ("graph", "nodes and topics"),
    "rqt_plot": ("plots", "values over time"),
    "rqt_image_view": ("images", "pictures"),
    "rqt_gui": ("", "plots, pictures, logs and 3D"),
    "rqt_console": ("console", "logs"),
    "rqt_topic": ("topics", "topics and their messages"),
    "rqt_publisher": ("controls", "topics and publishes on them"),
    "rqt_service_caller": ("services", "services and calls them"),
    "rqt_reconfigure": ("parameters", "parameters and sets them"),
    "rqt_robot_monitor": ("diagnostics", "diagnostics"),
    "rqt_robot_steering": ("drive", "a joystick that drives the robot"),
}
_OTHER_WINDOW = ("", "the robot")

# Without a browser, these commands show the same in the terminal.
_TERMINAL_VIEWS = {"rqt_graph": ("graph",), "rqt_plot": ("role", "rqt-plot")}

# RViz's options with a value, and those that name the file of displays.
_RVIZ_VALUES = {"-d", "--display-config", "-s", "--splash-screen", "--help-file", "-f", "--fixed-frame", "-t"}
_RVIZ_FILE = {"-d", "--display-config"}


def replacement_line(package: str, environ: Mapping[str, str], *, in_terminal: bool = False) -> str | None:
    """Return the line about the replacement for an rviz or rqt program, None if it is not needed."""
    if package not in _WINDOWS and not package.startswith("rqt_"):
        return None
    if window_program(package, package, environ) is not None:
        return None
    _, shown = _WINDOWS.get(package, _OTHER_WINDOW)
    if in_terminal and package in _TERMINAL_VIEWS:
        return f"{package} is not installed here; `rostether {package.removeprefix('rqt_')}` shows {shown}"
    return f"{package} is not installed here; the dashboard shows {shown}"


def view_command(package: str, arguments: Sequence[str], *, in_terminal: bool = False) -> list[str]:
    """Return the command line that replaces a window of rviz or rqt with its arguments."""
    panel, shown = window_view(package, arguments)
    if in_terminal and package in _TERMINAL_VIEWS:
        return own_command(*_TERMINAL_VIEWS[package], *shown)
    words = ["--panel", panel, *(word for each in shown for word in ("--show", each))] if panel else []
    return own_command("dashboard", *words, *(each for each in arguments if ":=" in each and each[0] != "-"))


def window_view(package: str, arguments: Sequence[str]) -> tuple[str, list[str]]:
    """Return the dashboard's panel for a window of rviz or rqt, and its contents from the arguments."""
    panel, _ = _WINDOWS.get(package, _OTHER_WINDOW)
    if not panel:
        return panel, []
    if panel == "scene":
        return panel, _rviz_file(arguments)
    return panel, [each for each in arguments if ":=" not in each and not each.startswith("-")]


def _rviz_file(arguments: Sequence[str]) -> list[str]:
    found: list[str] = []
    words = iter(arguments)
    for word in words:
        name, has_value, value = word.partition("=")
        if word in _RVIZ_VALUES:
            value = next(words, "")
        elif not has_value:
            # A file without an option is the file of displays.
            name, value = "-d", "" if word.startswith("-") or ":=" in word else word
        if name in _RVIZ_FILE and value:
            found = [value]
    return found


def window_program(package: str, name: str, environ: Mapping[str, str]) -> Path | None:
    """Return the installed rviz or rqt program, None if there is none."""
    for library in library_folders(package, None, environ):
        if os.access(library / name, os.X_OK) and (library / name).is_file():
            return library / name
    from rostether.cli.launch.shims import real_program

    # A shim would start this command again.
    return real_program(name, environ.get("PATH", os.defpath))

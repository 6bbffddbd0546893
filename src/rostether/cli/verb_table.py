"""The verbs of the `rostether` command: the module of each, and its line in the help."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator

from rostether.cli.shell.verbs import VerbEntry, verb_entries

_BY_HEADING = {
    "Boards": {
        "demo": ("demo.demo:demo", "Run a simulated board; needs no hardware."),
        "serve": ("bridge.serve:serve", "Connect boards to the ROS graph."),
        "serial-node": (
            "bridge.serial_node:serial_node",
            "Connect one board, with the arguments of serial_node.py.",
        ),
        "doctor": ("bridge.doctor:doctor", "Diagnose why a board does not connect."),
        "monitor": ("bridge.monitor:monitor", "Monitor all boards and their topics live."),
        "ports": ("bridge.ports:ports", "List serial ports and the devices on them."),
        "board": ("groups:board", "Run sketches on simulated boards."),
        "link": ("groups:link", "Record, show and replay the bytes on a board's line."),
        "xbee": ("groups:xbee", "Set up XBee radios, and simulate a network."),
        "conformance": (
            "link.conformance:conformance",
            "Check whether a client library speaks the wire protocol.",
        ),
    },
    "Sketches": {
        "new": ("firmware.new:new", "Write a new sketch."),
        "firmware": ("groups:firmware", "Build, measure and flash sketches; generate their library."),
        "flash": ("firmware.build:flash", "Build and flash a sketch, and connect the board."),
    },
    "Views": {
        "dashboard": ("dashboard.dashboard:dashboard", "Show the robot in a browser."),
        "graph": ("plot.graph:show_graph", "Show nodes and topics as text or as a picture."),
        "plot": ("plot.plot:plot", "Plot topic values over time, live or to a file."),
        "foxglove": ("gateway.foxglove:foxglove", "Connect Foxglove to the graph."),
        "rosbridge": ("gateway.rosbridge:rosbridge", "Connect web pages to the graph, like rosbridge."),
    },
    "ROS graph": {
        "core": ("bridge.core:core", "Run a ROS master, like roscore."),
        "topic": ("groups:topic", "List, print, publish and measure topics."),
        "node": ("groups:node", "List, show, ping and stop nodes."),
        "service": ("groups:service", "List, show and call services."),
        "param": ("groups:param", "Read and write parameters."),
        "msg": ("msg.group:msg", "Show message definitions."),
        "srv": ("msg.group:srv", "Show service definitions."),
        "interface": ("msg.interface:interface", "Show definitions of ROS 2, like ros2 interface."),
        "tf": ("groups:tf", "Show and publish transforms between frames."),
        "relay": ("bridge.relay:relay", "Relay topics and services between ROS 1 and ROS 2."),
    },
    "Recordings": {
        "bag": ("groups:bag", "Record, replay and inspect bags."),
        "export": ("bag.export:export", "Export a recording to CSV or Parquet."),
    },
    "Packages and launch files": {
        "run": ("launch.run:run", "Run a node of a package, like rosrun."),
        "launch": ("launch.launch:launch", "Start the nodes of launch files, like roslaunch."),
        "role": ("role.group:role", "Run a standard ROS node that launch files start."),
        "pkg": ("launch.pkg:pkg", "Create, list and find packages."),
        "urdf": ("robot.urdf:urdf", "Check and show robot descriptions."),
        "xacro": ("robot.urdf:xacro", "Expand a xacro file."),
        "env": ("launch.shims:env", "Add roslaunch, rostopic and other ROS 1 commands to PATH."),
    },
    "Robots and fleets": {
        "up": ("platform.up:up", "Run all parts of a robot, from one file."),
        "install": ("platform.install:install", "Start a robot's parts at boot."),
        "uninstall": ("platform.install:uninstall", "Stop starting parts at boot."),
        "status": ("platform.install:status", "Show what starts at boot, and whether it runs."),
        "sensor": ("platform.sensor:sensor", "List, show and rename sensors."),
        "fleet": ("platform.fleet:fleet", "List, drive and stop many robots."),
    },
    "This machine": {
        "self-check": ("bridge.self_check:self_check", "Show which optional parts work on this machine."),
        "completion": ("shell.completion:completion", "Print shell completion code."),
    },
}
VERBS: dict[str, VerbEntry] = {
    name: entry
    for heading, verbs in _BY_HEADING.items()
    for name, entry in verb_entries("rostether.cli", verbs, heading=heading).items()
}

# First words that users of ROS, ROS 2, micro-ROS and Arduino's tools type, and the commands for them.
WORDS_OF_OTHER_TOOLS: dict[str, tuple[str, ...]] = {
    "agent": ("serve",),
    "bridge": ("serve", "relay"),
    "catkin_make": ("pkg make",),
    "compile": ("firmware build",),
    "connect": ("serve",),
    "create": ("new sensor", "pkg create"),
    "devices": ("ports",),
    "gui": ("dashboard",),
    "init": ("new sensor", "pkg create"),
    "joystick": ("dashboard",),
    "log": ("topic echo /rosout",),
    "logs": ("topic echo /rosout",),
    "make_libraries.py": ("firmware lib",),
    "ros_lib": ("firmware lib",),
    "rosserial": ("serve", "serial-node"),
    "rqt": ("dashboard",),
    "rqt_graph": ("graph",),
    "rqt_plot": ("plot",),
    "rviz": ("dashboard",),
    "scan": ("ports",),
    "serial": ("serve", "serial-node"),
    "serial_node.py": ("serial-node",),
    "simulate": ("board run", "demo"),
    "simulator": ("board run", "demo"),
    "sketch": ("new sensor", "firmware build"),
    "start": ("serve", "up"),
    "teleop": ("dashboard",),
    "version": ("--version",),
    "view_frames": ("tf tree",),
    "web": ("dashboard",),
    "wtf": ("doctor", "self-check"),
}
_PORT = re.compile(r"/dev/\w.*|COM\d+|[a-z]+://.*")


def suggest(word: str) -> Iterator[str]:
    """Yield the commands that a user may mean by a first word that is not a command."""
    yield from WORDS_OF_OTHER_TOOLS.get(word, ())
    if (tool := word.removeprefix("ros")) != word and tool in VERBS:
        yield tool
    if _PORT.fullmatch(word):
        yield f"serve {shlex.quote(word)}"

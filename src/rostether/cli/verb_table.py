"""The verbs of the `rostether` command: the module of each, and its line in the help."""

from __future__ import annotations

from rostether.cli.shell.verbs import VerbEntry

VERBS = {
    "demo": VerbEntry("rostether.cli.demo.demo:demo", "Run a simulated board; needs no hardware."),
    "serve": VerbEntry("rostether.cli.bridge.serve:serve", "Connect boards to the ROS graph."),
    "serial-node": VerbEntry(
        "rostether.cli.bridge.serial_node:serial_node",
        "Connect one board, with the arguments of serial_node.py.",
    ),
    "board": VerbEntry("rostether.cli.groups:board", "Run sketches on simulated boards."),
    "xbee": VerbEntry("rostether.cli.groups:xbee", "Set up XBee radios, and simulate a network."),
    "doctor": VerbEntry("rostether.cli.bridge.doctor:doctor", "Diagnose why a board does not connect."),
    "self-check": VerbEntry(
        "rostether.cli.bridge.self_check:self_check",
        "Show which optional parts work on this machine.",
    ),
    "monitor": VerbEntry("rostether.cli.bridge.monitor:monitor", "Monitor all boards and their topics live."),
    "link": VerbEntry("rostether.cli.groups:link", "Record, show and replay the bytes on a board's line."),
    "conformance": VerbEntry(
        "rostether.cli.link.conformance:conformance",
        "Check whether a client library speaks the wire protocol.",
    ),
    "ports": VerbEntry("rostether.cli.bridge.ports:ports", "List serial ports and the devices on them."),
    "relay": VerbEntry(
        "rostether.cli.bridge.relay:relay", "Relay topics and services between ROS 1 and ROS 2."
    ),
    "core": VerbEntry("rostether.cli.bridge.core:core", "Run a ROS master, like roscore."),
    "topic": VerbEntry("rostether.cli.groups:topic", "List, print, publish and measure topics."),
    "node": VerbEntry("rostether.cli.groups:node", "List, show, ping and stop nodes."),
    "service": VerbEntry("rostether.cli.groups:service", "List, show and call services."),
    "sensor": VerbEntry("rostether.cli.platform.sensor:sensor", "List, show and rename sensors."),
    "fleet": VerbEntry("rostether.cli.platform.fleet:fleet", "List, drive and stop many robots."),
    "tf": VerbEntry("rostether.cli.groups:tf", "Show and publish transforms between frames."),
    "urdf": VerbEntry("rostether.cli.robot.urdf:urdf", "Check and show robot descriptions."),
    "xacro": VerbEntry("rostether.cli.robot.urdf:xacro", "Expand a xacro file."),
    "param": VerbEntry("rostether.cli.groups:param", "Read and write parameters."),
    "msg": VerbEntry("rostether.cli.msg.group:msg", "Show message definitions."),
    "srv": VerbEntry("rostether.cli.msg.group:srv", "Show service definitions."),
    "interface": VerbEntry(
        "rostether.cli.msg.interface:interface", "Show definitions of ROS 2, like ros2 interface."
    ),
    "run": VerbEntry("rostether.cli.launch.run:run", "Run a node of a package, like rosrun."),
    "launch": VerbEntry(
        "rostether.cli.launch.launch:launch", "Start the nodes of launch files, like roslaunch."
    ),
    "up": VerbEntry("rostether.cli.platform.up:up", "Run all parts of a robot, from one file."),
    "install": VerbEntry("rostether.cli.platform.install:install", "Start a robot's parts at boot."),
    "uninstall": VerbEntry("rostether.cli.platform.install:uninstall", "Stop starting parts at boot."),
    "status": VerbEntry(
        "rostether.cli.platform.install:status", "Show what starts at boot, and whether it runs."
    ),
    "pkg": VerbEntry("rostether.cli.launch.pkg:pkg", "Create, list and find packages."),
    "role": VerbEntry("rostether.cli.role.group:role", "Run a standard ROS node that launch files start."),
    "bag": VerbEntry("rostether.cli.groups:bag", "Record, replay and inspect bags."),
    "export": VerbEntry("rostether.cli.bag.export:export", "Export a recording to CSV or Parquet."),
    "dashboard": VerbEntry("rostether.cli.dashboard.dashboard:dashboard", "Show the robot in a browser."),
    "foxglove": VerbEntry("rostether.cli.gateway.foxglove:foxglove", "Connect Foxglove to the graph."),
    "rosbridge": VerbEntry(
        "rostether.cli.gateway.rosbridge:rosbridge", "Connect web pages to the graph, like rosbridge."
    ),
    "graph": VerbEntry(
        "rostether.cli.plot.graph:show_graph", "Show nodes and topics as text or as a picture."
    ),
    "plot": VerbEntry("rostether.cli.plot.plot:plot", "Plot topic values over time, live or to a file."),
    "firmware": VerbEntry(
        "rostether.cli.groups:firmware", "Build, measure and flash sketches; generate their library."
    ),
    "new": VerbEntry("rostether.cli.firmware.new:new", "Write a new sketch."),
    "flash": VerbEntry(
        "rostether.cli.launch.flash:flash", "Build and flash a sketch, and connect the board."
    ),
    "env": VerbEntry(
        "rostether.cli.launch.shims:env", "Type roslaunch, rostopic and other ROS 1 commands as before."
    ),
    "completion": VerbEntry("rostether.cli.shell.completion:completion", "Print shell completion code."),
}

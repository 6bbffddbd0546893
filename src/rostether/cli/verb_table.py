"""The verbs of the `rostether` command: where each lives, and the line that help shows for it."""

from __future__ import annotations

from rostether.cli.shell.verbs import VerbEntry

VERBS = {
    "demo": VerbEntry("rostether.cli.bridge.demo:demo", "Show a simulated board live, no hardware needed."),
    "serve": VerbEntry("rostether.cli.bridge.serve:serve", "Bridge boards into the ROS graph."),
    "serial-node": VerbEntry(
        "rostether.cli.bridge.serial_node:serial_node", "Bridge one board, typed as for serial_node.py."
    ),
    "board": VerbEntry("rostether.cli.board.group:board", "Run sketches on simulated boards."),
    "doctor": VerbEntry("rostether.cli.bridge.doctor:doctor", "Say why a board does not connect."),
    "monitor": VerbEntry("rostether.cli.bridge.monitor:monitor", "Watch all boards and their topics, live."),
    "link": VerbEntry("rostether.cli.link.group:link", "Record a board's line, show it, play it again."),
    "ports": VerbEntry("rostether.cli.bridge.ports:ports", "List serial ports with what they are."),
    "relay": VerbEntry(
        "rostether.cli.bridge.relay:relay", "Carry topics and services between ROS 1 and ROS 2."
    ),
    "core": VerbEntry("rostether.cli.bridge.core:core", "Run the ROS master alone, like roscore."),
    "topic": VerbEntry("rostether.cli.topic.group:topic", "List, show, publish and measure topics."),
    "node": VerbEntry("rostether.cli.node.group:node", "List, show, ping and stop nodes."),
    "service": VerbEntry("rostether.cli.service.group:service", "List, show and call services."),
    "tf": VerbEntry("rostether.cli.robot.tf:tf", "Show and publish the transforms of a robot's frames."),
    "urdf": VerbEntry("rostether.cli.robot.urdf:urdf", "Check and show robot descriptions."),
    "xacro": VerbEntry("rostether.cli.robot.xacro:xacro", "Expand a xacro file."),
    "param": VerbEntry("rostether.cli.param.group:param", "Read and write parameters."),
    "msg": VerbEntry("rostether.cli.msg.group:msg", "Show message definitions."),
    "srv": VerbEntry("rostether.cli.msg.group:srv", "Show service definitions."),
    "run": VerbEntry("rostether.cli.launch.run:run", "Run a node of a package, like rosrun."),
    "launch": VerbEntry(
        "rostether.cli.launch.launch:launch", "Start what launch files ask for, like roslaunch."
    ),
    "pkg": VerbEntry("rostether.cli.launch.pkg:pkg", "Create, list and find packages."),
    "role": VerbEntry("rostether.cli.role.group:role", "Be one of the nodes that launch files name."),
    "bag": VerbEntry("rostether.cli.bag.group:bag", "Record topics, play them again, look at recordings."),
    "export": VerbEntry("rostether.cli.bag.export:export", "Write what a recording holds as CSV or Parquet."),
    "foxglove": VerbEntry("rostether.cli.gateway.foxglove:foxglove", "Let Foxglove show and use the graph."),
    "rosbridge": VerbEntry(
        "rostether.cli.gateway.rosbridge:rosbridge", "Let web pages use the graph, as rosbridge does."
    ),
    "graph": VerbEntry(
        "rostether.cli.plot.graph:show_graph", "Show nodes and topics, as text or as a picture."
    ),
    "plot": VerbEntry(
        "rostether.cli.plot.plot:plot", "Draw values of topics over time, live or into a file."
    ),
    "firmware": VerbEntry(
        "rostether.cli.firmware.group:firmware", "Build, size and flash sketches; make their library."
    ),
    "env": VerbEntry("rostether.cli.launch.env:env", "Let roslaunch, rostopic and others be typed as ever."),
    "completion": VerbEntry("rostether.cli.shell.completion:completion", "Print shell completion code."),
}

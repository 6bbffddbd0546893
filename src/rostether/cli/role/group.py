"""`rostether role`: the standard nodes of launch files, one verb each.

`served_nodes` maps their ROS names to these verbs.
"""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_LIBRARIES = "rostether.cli.launch.pkg_make"
_SERVERS = "rostether.cli.bridge.rosserial_server"
_TOPICS = "rostether.cli.role.topic_tools"
_JOINTS = "rostether.cli.role.robot"
_SENSORS = "rostether.cli.platform.sensor_roles"
_STATIC = "rostether.cli.robot.tf_static"

ROLES = {
    "make-libraries": VerbEntry(
        f"{_LIBRARIES}:make_libraries", "Write the Arduino library, typed as for make_libraries.py."
    ),
    "rosserial-server-serial": VerbEntry(
        f"{_SERVERS}:serial", "Bridge one board, like rosserial_server's serial_node."
    ),
    "rosserial-server-socket": VerbEntry(
        f"{_SERVERS}:socket", "Bridge boards over TCP, like rosserial_server's socket_node."
    ),
    "rosserial-server-udp": VerbEntry(
        f"{_SERVERS}:udp", "Bridge a board over UDP, like rosserial_server's udp_socket_node."
    ),
    "message-info-service": VerbEntry(
        f"{_SERVERS}:message_info", "Tell the md5sums of types, like message_info_service.py."
    ),
    "xbee-network": VerbEntry(
        "rostether.cli.xbee.network:xbee_network", "Bridge boards on XBee radios, like xbee_network.py."
    ),
    "robot-state-publisher": VerbEntry(
        "rostether.cli.role.robot:robot_state_publisher", "Turn joint states into transforms."
    ),
    "joint-state-publisher": VerbEntry(f"{_JOINTS}:joint_state_publisher", "Publish joint states."),
    "joint-state-publisher-gui": VerbEntry(
        f"{_JOINTS}:joint_state_publisher_gui", "Publish joint states set by sliders in the terminal."
    ),
    "static-transform-publisher": VerbEntry(
        f"{_STATIC}:static_transform_publisher", "Publish a static transform, like tf2_ros."
    ),
    "tf-static-transform-publisher": VerbEntry(
        f"{_STATIC}:static_transform_publisher", "Publish a static transform, like tf."
    ),
    "relay": VerbEntry(f"{_TOPICS}:relay", "Publish a topic again under another name."),
    "throttle": VerbEntry(f"{_TOPICS}:throttle", "Publish a topic again at a limited rate."),
    "mux": VerbEntry(f"{_TOPICS}:mux", "Publish one of several topics, chosen by a service."),
    "mux-select": VerbEntry(f"{_TOPICS}:mux_select", "Choose the topic that a mux publishes."),
    "mux-add": VerbEntry(f"{_TOPICS}:mux_add", "Add an input to a mux."),
    "mux-delete": VerbEntry(f"{_TOPICS}:mux_delete", "Remove an input from a mux."),
    "mux-list": VerbEntry(f"{_TOPICS}:mux_list", "List the inputs of a mux."),
    "joy-node": VerbEntry("rostether.cli.role.joy:joy_node", "Publish a joystick's axes and buttons."),
    "arduino-control": VerbEntry(
        "rostether.cli.platform.sensing:arduino_control", "Turn a joystick into commands for a robot."
    ),
    "multicast-topic-bridge": VerbEntry(
        "rostether.cli.platform.multicast:multicast_topic_bridge", "Send a topic to a multicast group."
    ),
    "multicast-topic-receiver": VerbEntry(
        "rostether.cli.platform.multicast:multicast_topic_receiver",
        "Publish messages that arrive from a multicast group.",
    ),
    "fleet-monitor": VerbEntry(
        "rostether.cli.platform.multicast:fleet_monitor",
        "Publish the state of the fleet's robots, and stop them.",
    ),
    "sensing-manager": VerbEntry(
        "rostether.cli.platform.sensing:sensing_manager", "Register sensors and publish their list."
    ),
    "digital-tester": VerbEntry(
        "rostether.cli.platform.sensing:digital_tester", "Publish test values as a sensor."
    ),
    "camera": VerbEntry("rostether.cli.platform.camera:camera", "Publish a camera as a sensor."),
    "analog": VerbEntry(f"{_SENSORS}:analog", "Publish a number of a file or a topic as a sensor."),
    "digital": VerbEntry(f"{_SENSORS}:digital", "Publish a GPIO line or a topic as a sensor."),
    "gps": VerbEntry(f"{_SENSORS}:gps", "Publish the positions of a receiver (NMEA) as a sensor."),
    "battery": VerbEntry(f"{_SENSORS}:battery", "Publish this computer's battery as a sensor."),
    "system-load": VerbEntry(f"{_SENSORS}:system_load", "Publish this computer's load as sensors."),
    "foxglove-bridge": VerbEntry(
        "rostether.cli.gateway.foxglove:foxglove_bridge", "Serve Foxglove, like foxglove_bridge."
    ),
    "rosapi-node": VerbEntry(
        "rostether.cli.gateway.rosbridge:rosapi_node",
        "Answer queries about the graph by services, like rosapi_node.",
    ),
    "rosbridge-websocket": VerbEntry(
        "rostether.cli.gateway.rosbridge:rosbridge_websocket", "Serve web pages, like rosbridge_websocket."
    ),
    "tf2-web-republisher": VerbEntry(
        "rostether.cli.role.robot:tf2_web_republisher", "Send web pages the transforms they ask for."
    ),
    "rqt-plot": VerbEntry("rostether.cli.plot.rqt_plot:rqt_plot", "Plot fields of topics, like rqt_plot."),
}


@click.group(
    cls=LazyGroup,
    verbs=ROLES,
    examples="""
    rostether role make-libraries ~/Arduino/libraries
    rostether role rosserial-server-serial _port:=/dev/ttyACM0 _baud:=115200
    """,
)
def role() -> None:
    """Run a standard ROS node, as `rostether run` and launch files do."""

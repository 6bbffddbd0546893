"""`rostether role`: the standard nodes of launch files, one verb each.

`builtin_nodes` maps their ROS names to these verbs.
"""

from __future__ import annotations

from rostether.cli.shell.verbs import verb_group

role = verb_group(
    "role",
    "Run a standard ROS node, as `rostether run` and launch files do.",
    {
        "make-libraries": (
            "launch.catkin:make_libraries",
            "Write the Arduino library, like make_libraries.py.",
        ),
        "rosserial-server-serial": (
            "bridge.rosserial_hosts:serial",
            "Bridge one board, like rosserial_server's serial_node.",
        ),
        "rosserial-server-socket": (
            "bridge.rosserial_hosts:socket",
            "Bridge boards over TCP, like rosserial_server's socket_node.",
        ),
        "rosserial-server-udp": (
            "bridge.rosserial_hosts:udp",
            "Bridge a board over UDP, like rosserial_server's udp_socket_node.",
        ),
        "message-info-service": (
            "bridge.rosserial_hosts:message_info",
            "Offer the md5sums of types, like message_info_service.py.",
        ),
        "xbee-network": (
            "bridge.rosserial_hosts:xbee_network",
            "Bridge boards on XBee radios, like xbee_network.py.",
        ),
        "robot-state-publisher": ("role.robot:robot_state_publisher", "Turn joint states into transforms."),
        "joint-state-publisher": ("role.robot:joint_state_publisher", "Publish joint states."),
        "joint-state-publisher-gui": (
            "role.robot:joint_state_publisher_gui",
            "Publish joint states set by sliders in the terminal.",
        ),
        "static-transform-publisher": (
            "robot.tf_static:static_transform_publisher",
            "Publish a static transform, like tf2_ros.",
        ),
        "tf-static-transform-publisher": (
            "robot.tf_static:static_transform_publisher",
            "Publish a static transform, like tf.",
        ),
        "relay": ("role.topic_tools:relay", "Publish a topic again under another name."),
        "throttle": ("role.topic_tools:throttle", "Publish a topic again at a limited rate."),
        "mux": ("role.topic_tools:mux", "Publish one of several topics, chosen by a service."),
        "mux-select": ("role.topic_tools:mux_select", "Choose the topic that a mux publishes."),
        "mux-add": ("role.topic_tools:mux_add", "Add an input to a mux."),
        "mux-delete": ("role.topic_tools:mux_delete", "Remove an input from a mux."),
        "mux-list": ("role.topic_tools:mux_list", "List the inputs of a mux."),
        "joy-node": ("role.joy:joy_node", "Publish a joystick's axes and buttons."),
        "arduino-control": (
            "platform.roles:arduino_control",
            "Turn a joystick into commands for a robot.",
        ),
        "multicast-topic-bridge": (
            "platform.roles:multicast_topic_bridge",
            "Send a topic to a multicast group.",
        ),
        "multicast-topic-receiver": (
            "platform.roles:multicast_topic_receiver",
            "Publish messages that arrive from a multicast group.",
        ),
        "fleet-monitor": (
            "platform.roles:fleet_monitor",
            "Publish the state of the fleet's robots, and stop them.",
        ),
        "sensing-manager": (
            "platform.roles:sensing_manager",
            "Register sensors and publish their list.",
        ),
        "digital-tester": ("platform.roles:digital_tester", "Publish test values as a sensor."),
        "camera": ("platform.sensor_roles:camera", "Publish a camera as a sensor."),
        "analog": ("platform.sensor_roles:analog", "Publish a number from a file or a topic as a sensor."),
        "digital": ("platform.sensor_roles:digital", "Publish a GPIO line or a topic as a sensor."),
        "gps": ("platform.sensor_roles:gps", "Publish the positions of a receiver (NMEA) as a sensor."),
        "battery": ("platform.sensor_roles:battery", "Publish this computer's battery as a sensor."),
        "system-load": ("platform.sensor_roles:system_load", "Publish this computer's load as sensors."),
        "foxglove-bridge": ("gateway.foxglove:foxglove_bridge", "Serve Foxglove, like foxglove_bridge."),
        "rosapi-node": (
            "gateway.rosbridge:rosapi_node",
            "Answer queries about the graph by services, like rosapi_node.",
        ),
        "rosbridge-websocket": (
            "gateway.rosbridge:rosbridge_websocket",
            "Serve web pages, like rosbridge_websocket.",
        ),
        "tf2-web-republisher": (
            "role.robot:tf2_web_republisher",
            "Send web pages the transforms that they request.",
        ),
        "rqt-plot": ("plot.plot:rqt_plot", "Plot fields of topics, like rqt_plot."),
    },
    """
    rostether role make-libraries ~/Arduino/libraries
    rostether role rosserial-server-serial _port:=/dev/ttyACM0 _baud:=115200
    """,
    package="rostether.cli",
)

"""The groups of verbs such as `rostether topic`: the module of each verb, and its line in the help."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry


@click.group(
    cls=LazyGroup,
    verbs={
        "list": VerbEntry("rostether.cli.topic.listing:list_topics", "List the topics."),
        "info": VerbEntry(
            "rostether.cli.topic.listing:info", "Show a topic's type, publishers and subscribers."
        ),
        "type": VerbEntry("rostether.cli.topic.listing:type_of", "Print the type of a topic or of a field."),
        "echo": VerbEntry("rostether.cli.topic.echo:echo", "Print the messages of a topic."),
        "pub": VerbEntry("rostether.cli.topic.pub:pub", "Publish messages."),
        "hz": VerbEntry("rostether.cli.topic.rates:hz", "Measure the message rate."),
        "bw": VerbEntry("rostether.cli.topic.rates:bw", "Measure the bandwidth of a topic."),
        "delay": VerbEntry("rostether.cli.topic.rates:delay", "Measure the age of messages on arrival."),
        "find": VerbEntry("rostether.cli.topic.listing:find", "List the topics of a type."),
    },
    examples="""
    rostether topic list
    rostether topic echo /ultrasound
    rostether topic pub -1 /toggle_led std_msgs/Empty
    rostether topic hz /imu_data
    """,
)
def topic() -> None:
    """List, show, publish and measure the topics of a ROS graph."""


@click.group(
    cls=LazyGroup,
    verbs={
        "list": VerbEntry("rostether.cli.node.verbs:list_nodes", "List the running nodes."),
        "info": VerbEntry(
            "rostether.cli.node.verbs:info", "Show what a node publishes, subscribes to and serves."
        ),
        "ping": VerbEntry("rostether.cli.node.verbs:ping", "Check whether a node answers, and how quickly."),
        "kill": VerbEntry("rostether.cli.node.verbs:kill", "Ask nodes to shut down."),
        "cleanup": VerbEntry("rostether.cli.node.verbs:cleanup", "Unregister dead nodes from the master."),
        "machine": VerbEntry("rostether.cli.node.verbs:machine", "List machines, or the nodes on one."),
    },
    examples="""
    rostether node list
    rostether node info /board
    rostether node ping -a
    """,
)
def node() -> None:
    """List, show, ping and stop the nodes of a ROS graph."""


@click.group(
    cls=LazyGroup,
    verbs={
        "list": VerbEntry("rostether.cli.service.verbs:list_services", "List the services."),
        "info": VerbEntry(
            "rostether.cli.service.verbs:info",
            "Show which node offers a service, its type and its arguments.",
        ),
        "call": VerbEntry("rostether.cli.service.verbs:call", "Call a service and print its response."),
        "type": VerbEntry("rostether.cli.service.verbs:type_of", "Print the type of a service."),
        "args": VerbEntry("rostether.cli.service.verbs:args", "Print the names of a service's arguments."),
        "find": VerbEntry("rostether.cli.service.verbs:find", "List the services of a type."),
        "node": VerbEntry("rostether.cli.service.verbs:node_of", "Print the node that offers a service."),
        "uri": VerbEntry("rostether.cli.service.verbs:uri_of", "Print the URI of a service."),
    },
    examples="""
    rostether service list
    rostether service call /set_led "data: true"
    rostether service type /set_led | rostether srv show
    """,
)
def service() -> None:
    """List, show and call the services of a ROS graph."""


@click.group(
    cls=LazyGroup,
    verbs={
        "list": VerbEntry("rostether.cli.param.verbs:list_params", "List the names of parameters."),
        "get": VerbEntry("rostether.cli.param.verbs:get", "Print a parameter, or all of a namespace."),
        "set": VerbEntry("rostether.cli.param.verbs:set_param", "Set a parameter."),
        "delete": VerbEntry("rostether.cli.param.verbs:delete", "Delete a parameter, or all of a namespace."),
        "describe": VerbEntry(
            "rostether.cli.param.verbs:describe", "Describe the parameters of a ROS 2 node."
        ),
        "dump": VerbEntry("rostether.cli.param.verbs:dump_params", "Write parameters to a YAML file."),
        "load": VerbEntry("rostether.cli.param.verbs:load", "Set the parameters of a YAML file."),
    },
    examples="""
    rostether param set /blink_hz 2.5
    rostether param get /blink_hz
    rostether param dump settings.yaml
    rostether param get --ros2 /board gain
    """,
)
def param() -> None:
    """Read and write the parameters of a ROS graph."""


@click.group(
    cls=LazyGroup,
    verbs={
        "record": VerbEntry("rostether.cli.bag.record:bag_record", "Record topics into a file."),
        "play": VerbEntry("rostether.cli.bag.play:bag_play", "Replay recordings into the graph."),
        "info": VerbEntry("rostether.cli.bag.info:bag_info", "Show the contents of a recording."),
        "check": VerbEntry("rostether.cli.bag.check:bag_check", "Check a recording for errors."),
        "filter": VerbEntry(
            "rostether.cli.bag.filter:bag_filter", "Keep the messages that match an expression."
        ),
        "cut": VerbEntry("rostether.cli.bag.cut:bag_cut", "Keep what was recorded at a time."),
        "convert": VerbEntry("rostether.cli.bag.convert:bag_convert", "Convert between formats."),
        "compress": VerbEntry("rostether.cli.bag.repack:bag_compress", "Compress recordings."),
        "decompress": VerbEntry("rostether.cli.bag.repack:bag_decompress", "Decompress recordings."),
        "reindex": VerbEntry(
            "rostether.cli.bag.repack:bag_reindex", "Repair recordings that were not closed."
        ),
    },
    examples="""
    rostether bag record --all -O drive.bag
    rostether bag info drive.bag
    rostether bag play drive.bag --rate 2
    """,
)
def bag() -> None:
    """Record and replay topics, in ROS 1 .bag files, MCAP files and ROS 2 bags.

    Files end with .bag, .mcap or .db3; a ROS 2 bag is a folder. LZ4 and Zstandard come with
    `pip install 'rostether[recording]'`.
    """


@click.group(
    cls=LazyGroup,
    verbs={
        "echo": VerbEntry("rostether.cli.robot.tf_echo:echo", "Print the transform between two frames."),
        "tree": VerbEntry("rostether.cli.robot.tf_tree:tree", "Show the tree of frames."),
        "monitor": VerbEntry(
            "rostether.cli.robot.tf_monitor:monitor", "Show the delay and rate of transforms."
        ),
        "static": VerbEntry("rostether.cli.robot.tf_static:static", "Publish a static transform."),
    },
    examples="""
    rostether tf tree
    rostether tf echo base_link gripper
    rostether tf static 0 0 0.1 0 0 0 base_link laser
    """,
)
def tf() -> None:
    """Show and publish the transforms between the frames of a robot."""


@click.group(
    cls=LazyGroup,
    verbs={
        "build": VerbEntry("rostether.cli.firmware.build:firmware_build", "Build a sketch."),
        "size": VerbEntry(
            "rostether.cli.firmware.size:firmware_size", "Show how much of the board's memory a sketch uses."
        ),
        "sim": VerbEntry(
            "rostether.cli.firmware.build:firmware_sim", "Build a sketch and run it on a simulated board."
        ),
        "upload": VerbEntry(
            "rostether.cli.firmware.build:firmware_upload", "Build a sketch and flash a board."
        ),
        "lib": VerbEntry("rostether.cli.firmware.lib:firmware_lib", "Generate the client library, ros_lib."),
    },
    examples="""
    rostether firmware size blink.ino --board uno                will it fit?
    rostether firmware upload blink.ino --board uno              build and flash
    rostether firmware lib ~/Arduino/libraries                   the library for the Arduino IDE
    """,
)
def firmware() -> None:
    """Build sketches for boards, and generate the client library that they use."""


@click.group(
    cls=LazyGroup,
    verbs={
        "run": VerbEntry(
            "rostether.cli.board.run:board_run", "Run a sketch or an ELF file on a simulated board."
        ),
    },
    examples="""
    rostether board run blink.ino --watch D13
    """,
)
def board() -> None:
    """Run real AVR firmware on simulated boards."""


@click.group(
    cls=LazyGroup,
    verbs={
        "record": VerbEntry("rostether.cli.link.record:link_record", "Serve a board and record its line."),
        "show": VerbEntry("rostether.cli.link.show:link_show", "List the frames of a capture."),
        "replay": VerbEntry(
            "rostether.cli.link.replay:link_replay",
            "Replay a capture into the graph as if its board were connected.",
        ),
    },
    examples="""
    rostether link record /dev/ttyACM0 problem.jsonl
    rostether link show problem.jsonl
    rostether link replay problem.jsonl
    """,
)
def link() -> None:
    """Record, show and replay the bytes on a board's line.

    A capture contains the bytes of the board and of the host, with times. Use it to show a problem without
    the board.
    """


@click.group(
    cls=LazyGroup,
    verbs={
        "setup": VerbEntry("rostether.cli.xbee.setup:xbee_setup", "Set up a radio for a network of boards."),
        "simulate": VerbEntry("rostether.cli.xbee.simulate:xbee_simulate", "Run a simulated radio network."),
    },
    examples="""
    rostether xbee setup --coordinator /dev/ttyUSB0
    rostether xbee setup /dev/ttyUSB1 1
    rostether xbee simulate --boards 8 --loss 0.05 --link ./xbee
    """,
)
def xbee() -> None:
    """Set up XBee radios, and simulate a network of them."""

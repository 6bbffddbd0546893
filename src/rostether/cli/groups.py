"""The groups of verbs such as `rostether topic`: the module of each verb, and its line in the help."""

from __future__ import annotations

from rostether.cli.shell.verbs import verb_group

topic = verb_group(
    "topic",
    "List, show, publish and measure the topics of a ROS graph.",
    {
        "list": ("verbs:list_topics", "List the topics."),
        "info": ("verbs:info", "Show a topic's type, publishers and subscribers."),
        "type": ("verbs:type_of", "Print the type of a topic or of a field."),
        "echo": ("verbs:echo", "Print the messages of a topic."),
        "pub": ("verbs:pub", "Publish messages."),
        "hz": ("rates:hz", "Measure the message rate."),
        "bw": ("rates:bw", "Measure the bandwidth of a topic."),
        "delay": ("rates:delay", "Measure the age of messages on arrival."),
        "find": ("verbs:find", "List the topics of a type."),
    },
    """
    rostether topic list
    rostether topic echo /ultrasound
    rostether topic pub -1 /toggle_led std_msgs/Empty
    rostether topic hz /imu_data
    """,
)

node = verb_group(
    "node",
    "List, show, ping and stop the nodes of a ROS graph.",
    {
        "list": ("verbs:list_nodes", "List the running nodes."),
        "info": ("verbs:info", "Show what a node publishes, subscribes to and serves."),
        "ping": ("verbs:ping_nodes", "Check whether a node answers, and how quickly."),
        "kill": ("verbs:kill_nodes", "Ask nodes to shut down."),
        "cleanup": ("verbs:cleanup_nodes", "Unregister dead nodes from the master."),
        "machine": ("verbs:list_machines", "List machines, or the nodes on one."),
    },
    """
    rostether node list
    rostether node info /board
    rostether node ping -a
    """,
)

service = verb_group(
    "service",
    "List, show and call the services of a ROS graph.",
    {
        "list": ("verbs:list_services", "List the services."),
        "info": ("verbs:info", "Show which node offers a service, its type and its arguments."),
        "call": ("verbs:call", "Call a service and print its response."),
        "type": ("verbs:type_of", "Print the type of a service."),
        "args": ("verbs:args", "Print the names of a service's arguments."),
        "find": ("verbs:find", "List the services of a type."),
        "node": ("verbs:node_of", "Print the node that offers a service."),
        "uri": ("verbs:uri_of", "Print the URI of a service."),
    },
    """
    rostether service list
    rostether service call /set_led "data: true"
    rostether service type /set_led | rostether srv show
    """,
)

param = verb_group(
    "param",
    "Read and write the parameters of a ROS graph.",
    {
        "list": ("verbs:list_params", "List the names of parameters."),
        "get": ("verbs:get", "Print a parameter, or all of a namespace."),
        "set": ("verbs:set_param", "Set a parameter."),
        "delete": ("verbs:delete", "Delete a parameter, or all of a namespace."),
        "describe": ("verbs:describe", "Describe the parameters of a ROS 2 node."),
        "dump": ("verbs:dump_params", "Write parameters to a YAML file."),
        "load": ("verbs:load", "Set the parameters of a YAML file."),
    },
    """
    rostether param set /blink_hz 2.5
    rostether param get /blink_hz
    rostether param dump settings.yaml
    rostether param get --ros2 /board gain
    """,
)

bag = verb_group(
    "bag",
    """Record and replay topics, in ROS 1 .bag files, MCAP files and ROS 2 bags.

    Files end with .bag, .mcap or .db3; a ROS 2 bag is a folder. For LZ4 and Zstandard, run
    `pip install 'rostether[recording]'`.
    """,
    {
        "record": ("record:bag_record", "Record topics into a file."),
        "play": ("play:bag_play", "Replay recordings into the graph."),
        "info": ("info:bag_info", "Show the contents of a recording."),
        "check": ("check:bag_check", "Check a recording for errors."),
        "filter": ("copying:bag_filter", "Keep the messages that match an expression."),
        "cut": ("copying:bag_cut", "Keep the messages of a period of time."),
        "convert": ("copying:bag_convert", "Convert between formats."),
        "compress": ("repack:bag_compress", "Compress recordings."),
        "decompress": ("repack:bag_decompress", "Decompress recordings."),
        "reindex": ("repack:bag_reindex", "Repair recordings that were not closed."),
    },
    """
    rostether bag record --all -O drive.bag
    rostether bag info drive.bag
    rostether bag play drive.bag --rate 2
    """,
)

tf = verb_group(
    "tf",
    "Show and publish the transforms between the frames of a robot.",
    {
        "echo": ("tf:echo", "Print the transform between two frames."),
        "tree": ("tf:tree", "Show the tree of frames."),
        "monitor": ("tf:monitor", "Show the delay and rate of transforms."),
        "static": ("tf_static:static", "Publish a static transform."),
    },
    """
    rostether tf tree
    rostether tf echo base_link gripper
    rostether tf static 0 0 0.1 0 0 0 base_link laser
    """,
    package="rostether.cli.robot",
    suggest=lambda word: ("tf tree",) if word == "view_frames" else (),
)

firmware = verb_group(
    "firmware",
    "Build sketches for boards, and generate the client library that they use.",
    {
        "build": ("build:firmware_build", "Build a sketch."),
        "size": ("size:firmware_size", "Show how much of the board's memory a sketch uses."),
        "sim": ("build:firmware_sim", "Build a sketch and run it on a simulated board."),
        "upload": ("build:firmware_upload", "Build a sketch and flash a board."),
        "lib": ("lib:firmware_lib", "Generate the client library, ros_lib."),
    },
    """
    rostether firmware size blink.ino --board uno                will it fit?
    rostether firmware upload blink.ino --board uno              build and flash
    rostether firmware lib ~/Arduino/libraries                   the library for the Arduino IDE
    """,
)

board = verb_group(
    "board",
    "Run sketches and firmware on simulated boards.",
    {
        "run": ("run:board_run", "Run a sketch or an ELF file on a simulated board."),
    },
    """
    rostether board run blink.ino --watch D13
    """,
    # As in arduino-cli.
    suggest=lambda word: ("ports",) if word == "list" else (),
)

link = verb_group(
    "link",
    """Record, show and replay the bytes on a board's line.

    A capture contains the bytes of the board and of the host, with times. Use it to show a problem without
    the board.
    """,
    {
        "record": ("replay:link_record", "Serve a board and record its line."),
        "show": ("show:link_show", "List the frames of a capture."),
        "replay": (
            "replay:link_replay",
            "Replay a capture into the graph as if its board were connected.",
        ),
    },
    """
    rostether link record /dev/ttyACM0 problem.jsonl
    rostether link show problem.jsonl
    rostether link replay problem.jsonl
    """,
)

xbee = verb_group(
    "xbee",
    "Set up XBee radios, and simulate a network of them.",
    {
        "setup": ("setup:xbee_setup", "Set up a radio for a network of boards."),
        "simulate": ("simulate:xbee_simulate", "Run a simulated radio network."),
    },
    """
    rostether xbee setup --coordinator /dev/ttyUSB0
    rostether xbee setup /dev/ttyUSB1 1
    rostether xbee simulate --boards 8 --loss 0.05 --link ./xbee
    """,
)

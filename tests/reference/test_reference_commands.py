"""Every command in five introductions to boards and ROS, typed as printed there.

Only the port differs: `PORT` is replaced by the pseudo-terminal of the test's board. `OTHER_COMMANDS` are the
printed commands that do not use rostether, so that the list is complete.
"""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator, Callable
from itertools import groupby
from pathlib import Path

import pytest
import pytest_asyncio

from interop.ros1_peers import free_port
from reference.terminal import TIMEOUT_S, Terminals
from rostether import Device
from rostether.cli.launch.shims import SHIMS

EXAMPLES = Path(__file__).parents[2] / "examples" / "mearm"

POLL_S = 0.05

OTHER_COMMANDS = (
    "git clone https://github.com/ros-drivers/rosserial",
    "sudo apt-get update",
    "sudo apt-get install arduino",
    "sudo apt-get install arduino arduino-core",
    "sudo apt-get install ros-kinectic-rosserial",
    "sudo apt-get install ros-indigo-rosserial",
    "sudo apt-get install ros-kinetic-rosserial-arduino",
    "sudo apt-get install ros-kinetic-rosserial",
    "sudo apt-get install ros-kinetic-rosserial ros-kinetic-rosserial-server ros-kinetic-rosserial-arduino",
    "sudo usermod -a -G dialout <username>",
    "sudo chmod 666 /dev/ttyACM0 or ttyS0",
    "arduino",
    "./arduino",
    "dmesg",
    "dmesg | grep tty",
    "ls /dev/tty*",
)
# In the order of each document.
GETTING_STARTED = (
    "mkdir -p ~/rosserial_ws/src",
    "cd ~/rosserial_ws/src",
    "catkin_init_workspace",
    "cd ~/rosserial_ws",
    "catkin_make",
    'echo "source ~/rosserial_ws/devel/setup.bash" >>~/.bashrc',
    "source ~/.bashrc",
    "roscore",
    "rosrun rosserial_arduino make_libraries.py .",
    "rosrun rosserial_python serial_node.py PORT",
    "rostopic list",
    # The document has an en dash instead of `--`.
    "rostopic pub toggle_led std_msgs/Empty –once",
    # With two s: a misprint of the document.
    "rossrun rosserial_python serial_node.py PORT",
    "rostopic echo /imu_data",
    "rostopic echo /tf",
)
BY_EXAMPLE = (
    "cd ~/sketchbook/libraries",
    "rm -rf ros_lib",
    "rosrun rosserial_arduino make_libraries.py",
    "cd ~/sketchbook/libraries/ros_lib/examples/",
    "ls",
    "roscore",
    "rosrun rosserial_python serial_node.py PORT",
    "rosmsg show sensor_msgs/Range",
    "rostopic echo /ultrasound",
    "rqt_plot",
)
EMBEDDED = (
    "roscore",
    "rosrun rosserial_python serial_node.py __name:=opencr _port:=PORT _baud:=115200",
    "rostopic pub -1 led_out std_msgs/Byte 1",
    "rostopic pub -1 led_out std_msgs/Byte 2",
    "rostopic pub -1 led_out std_msgs/Byte 4",
    "rostopic pub -1 led_out std_msgs/Byte 8",
    "rostopic pub -1 led_out std_msgs/Byte 0",
    "rqt_graph",
)
MEARM = (
    "cd ~/catkin_ws/src",
    "catkin_init_workspace",
    "catkin_create_pkg mearm_model std_msgs rospy roscpp rosserial_arduino rosserial_client",
    "roslaunch mearm_move display.launch",
    "rosrun rosserial_python serial_node.py _port:=PORT _baud:=115200",
    "roslaunch mearm_move service.launch",
    "rosservice call /select_position_set \"set_name: 'set3'\"",
)
# The fifth document, a report on a sensing platform, prints no command.

TYPED = (*GETTING_STARTED, *BY_EXAMPLE, *EMBEDDED, *MEARM)

pytestmark = pytest.mark.timeout(300)


def test_typed_commands_are_of_rostether_or_the_shell() -> None:
    shims = {command.split()[0] for command in TYPED} & set(SHIMS)
    assert {command.split()[0] for command in TYPED} - shims == {"cd", "mkdir", "rm", "ls", "echo", "source"}
    assert not {command.split()[0] for command in OTHER_COMMANDS} & set(SHIMS)


@pytest_asyncio.fixture
async def terminals(tmp_path: Path) -> AsyncIterator[Terminals]:
    terminals = Terminals(tmp_path / "home", f"http://127.0.0.1:{free_port()}")
    try:
        await terminals.start()
        yield terminals
    finally:
        await terminals.close()


async def type_until_listed(terminals: Terminals, command: str, *topics: str) -> None:
    """Repeat a command until it prints topics: the bridge logs them shortly before the master has them."""
    async with asyncio.timeout(TIMEOUT_S):
        while not set(topics) <= set((await terminals.type(command)).split()):
            pass


async def type_until_arrived(terminals: Terminals, command: str, has_arrived: Callable[[], bool]) -> None:
    """Type a command that publishes for three seconds. Repeat it if that was too short on a busy machine."""
    for _ in range(10):
        await terminals.type(command)
        if has_arrived():
            return
    raise AssertionError(f"nothing of `{command}` arrived")


async def test_getting_started(terminals: Terminals, tmp_path: Path) -> None:
    typed = iter(GETTING_STARTED)
    for _ in range(2):
        await terminals.type(next(typed))
    assert "CMakeLists.txt" in await terminals.type(next(typed))
    await terminals.type(next(typed))
    assert "nothing needs to be built" in await terminals.type(next(typed))
    for _ in range(2):
        await terminals.type(next(typed))
    core = await terminals.leave_running(next(typed))
    await core.wait_for("ROS_MASTER_URI=")
    assert "ros_lib" in await terminals.type(next(typed))
    assert (terminals.home / "rosserial_ws" / "ros_lib").is_dir()
    port = str(tmp_path / "ttyACM0")
    toggles: list[object] = []
    async with Device(f"pty:{port}") as board:
        board.subscriber("toggle_led", "std_msgs/Empty", toggles.append)
        node = await terminals.leave_running(next(typed).replace("PORT", port))
        await node.wait_for(r"Setup subscriber on toggle_led \[std_msgs/Empty\]")
        await type_until_listed(terminals, next(typed), "/toggle_led")
        await type_until_arrived(terminals, next(typed), lambda: len(toggles) > 0)
        await node.interrupt()
    port = str(tmp_path / "ttyACM1")
    async with Device(f"pty:{port}") as board:
        imu = board.publisher("imu_data", "sensor_msgs/Imu")
        transform = board.publisher("tf", "tf/tfMessage")
        node = await terminals.leave_running(next(typed).replace("PORT", port))
        await node.wait_for(r"Setup publisher on tf \[tf/tfMessage\]")
        await type_until_listed(terminals, "rostopic list", "/imu_data", "/tf")
        for publisher, message, expected in (
            (imu, {"orientation": {"w": 1.0}}, r"^orientation: *\n.*w: 1\.0"),
            (transform, {"transforms": [{"child_frame_id": "imu_link"}]}, "child_frame_id: .?imu_link"),
        ):
            echo = await terminals.leave_running(next(typed))
            while "---" not in echo.printed:
                publisher.publish(message)
                await asyncio.sleep(POLL_S)
            await echo.wait_for(expected)
            await echo.interrupt()
    assert next(typed, None) is None


async def test_by_example(terminals: Terminals, tmp_path: Path) -> None:
    typed = iter(BY_EXAMPLE)
    (terminals.home / "sketchbook" / "libraries").mkdir(parents=True)
    for _ in range(3):
        await terminals.type(next(typed))
    await terminals.type(next(typed))
    examples = set((await terminals.type(next(typed))).split())
    documented = (
        "ADC button_example IrRanger pubsub ServoControl Ultrasound Blink Clapper Logging ServiceClient"
    )
    documented += " Temperature BlinkM HelloWorld Odom ServiceServer TimeTF"
    assert {name.lower().replace("_", "") for name in documented.split()} <= {
        name.lower().replace("_", "") for name in examples
    }
    core = await terminals.leave_running(next(typed))
    await core.wait_for("ROS_MASTER_URI=")
    port = str(tmp_path / "ttyACM0")
    async with Device(f"pty:{port}") as board:
        ultrasound = board.publisher("ultrasound", "sensor_msgs/Range")
        node = await terminals.leave_running(next(typed).replace("PORT", port))
        await node.wait_for(r"ROS Serial Python Node.*Connecting to \S+ at 57600 baud")
        await node.wait_for(r"Note: publish buffer size is \d+ bytes")
        await node.wait_for(r"Setup publisher on ultrasound \[sensor_msgs/Range\]")
        shown = await terminals.type(next(typed))
        assert [line.strip() for line in shown.split("\n")][:4] == [
            "uint8 ULTRASOUND=0",
            "uint8 INFRARED=1",
            "std_msgs/Header header",
            "uint32 seq",
        ]
        echo = await terminals.leave_running(next(typed))
        while "---" not in echo.printed:
            ultrasound.publish(range=50.0, field_of_view=0.26, max_range=400.0)
            await asyncio.sleep(POLL_S)
        await echo.wait_for(r"field_of_view: 0\.2599999904632568.*max_range: 400\.0\nrange: 50\.0\n---")
        plot = await terminals.leave_running(next(typed))
        # Without an argument, rqt_plot opens an empty window; rostether's plots what is published.
        await plot.wait_for("rostether plot .*/ultrasound/range")
        while "400" not in plot.printed:
            assert plot.process.returncode is None, plot.printed
            ultrasound.publish(range=50.0, field_of_view=0.26, max_range=400.0)
            await asyncio.sleep(POLL_S)
    assert next(typed, None) is None


async def test_embedded(terminals: Terminals, tmp_path: Path) -> None:
    typed = iter(EMBEDDED)
    core = await terminals.leave_running(next(typed))
    await core.wait_for("ROS_MASTER_URI=")
    port = str(tmp_path / "ttyACM0")
    lights: list[int] = []
    async with Device(f"pty:{port}") as board:
        board.subscriber("led_out", "std_msgs/Byte", lambda message: lights.append(message.data))
        node = await terminals.leave_running(next(typed).replace("PORT", port))
        await node.wait_for(r"ROS Serial Python Node.*Connecting to \S+ at 115200 baud")
        await node.wait_for(r"Note: subscribe buffer size is \d+ bytes")
        await node.wait_for(r"Setup subscriber on led_out \[std_msgs/Byte\]")
        for light in (1, 2, 4, 8, 0):
            await type_until_arrived(terminals, next(typed), lambda light=light: lights[-1:] == [light])  # type: ignore[misc]
        assert [light for light, _ in groupby(lights)] == [1, 2, 4, 8, 0]
        graph = await terminals.leave_running(next(typed))
        await graph.wait_for("opencr")
        await graph.finish()
    assert next(typed, None) is None


async def test_mearm(terminals: Terminals, tmp_path: Path) -> None:
    typed = iter(MEARM)
    source = terminals.home / "catkin_ws" / "src"
    source.mkdir(parents=True)
    for _ in range(3):
        await terminals.type(next(typed))
    # The file that the document adds to the package, and the second package with the launch file.
    shutil.copytree(EXAMPLES, source, dirs_exist_ok=True)
    display = await terminals.leave_running(next(typed))
    await display.wait_for("joint_state_publisher_gui")
    port = str(tmp_path / "ttyACM0")
    angles: list[tuple[int, ...]] = []
    async with Device(f"pty:{port}", msg_paths=[source]) as board:
        board.subscriber(
            "servo_pose_server",
            "mearm_model/ServoAngles",
            lambda each: angles.append((each.servo1, each.servo2, each.servo3, each.servo4)),
        )
        serial = next(typed).replace("PORT", port)
        node = await terminals.leave_running(serial)
        await node.wait_for(r"Setup subscriber on servo_pose_server \[mearm_model/ServoAngles\]")
        await display.interrupt()
        await node.interrupt()
        service = await terminals.leave_running(next(typed))
        node = await terminals.leave_running(serial)
        await node.wait_for(r"Setup subscriber on servo_pose_server \[mearm_model/ServoAngles\]")
        while "/select_position_set" not in (await terminals.type("rosservice list")).split():
            assert service.process.returncode is None, service.printed
        assert "success: True" in await terminals.type(next(typed))
        while (-14, 0, 14, 29) not in angles:
            assert service.process.returncode is None, service.printed
            await asyncio.sleep(POLL_S)
    assert next(typed, None) is None

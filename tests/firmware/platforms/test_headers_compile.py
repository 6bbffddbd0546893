"""Each platform's header, with a node that uses all of it, compiles without a warning for its boards.

If a vendor's kit is not available, the header is compiled against declarations of the functions that it
calls.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from firmware.platforms.programs import EXAMPLES, NODE, STUBS, WARNINGS
from rostether.codegen.arduino_library import write_library
from rostether.codegen.library_source import client_library
from rostether.msgdef.registry import Registry
from unit.codegen.compilers import ARDUINO_CORE

ARM = ("arm-none-eabi-g++", "-Os", "-mcpu=cortex-m4", "-mthumb", "-fno-exceptions")
ARDUINO = ("-DARDUINO=10819", f"-I{STUBS}/arduino")

EMBEDDED = {
    "mbed 6": ("-D__MBED__", "-std=gnu++14", f"-I{STUBS}/mbed6"),
    "mbed 2": ("-D__MBED__", f"-I{STUBS}/mbed2"),
    "mbed 6, own pins": ("-D__MBED__", "-std=gnu++14", "-DMBEDTX=p13", "-DMBEDRX=p14", f"-I{STUBS}/mbed6"),
    "STM32 HAL": ("-DUSE_HAL_DRIVER", f"-I{STUBS}/stm32"),
    "TM4C123": ("-DPART_TM4C123GH6PM", f"-I{STUBS}/tivaware"),
    "TM4C129": ("-DTARGET_IS_TM4C129_RA0", "-DTM4C129FREQ=120000000", f"-I{STUBS}/tivaware"),
}
BOARDS = {
    "ESP8266": ("-DESP8266",),
    "ESP32": ("-DESP32",),
    "ESP32 with Ethernet": ("-DESP32", "-DESP32_ETH"),
    "Uno R4 WiFi": ("-DARDUINO_UNOWIFIR4",),
    "Pico W": ("-DARDUINO_ARCH_RP2040", "-DARDUINO_RASPBERRY_PI_PICO_W"),
    "Teensy": ("-DTEENSYDUINO=157",),
    "Due": ("-D_SAM3XA_", "-DUSBCON"),
    "SAMD": ("-DARDUINO_ARCH_SAMD", "-DUSBCON"),
    "OpenCR": ("-D__OPENCR__",),
    "Maple Mini": ("-D__STM32F1__",),
    "STM32duino": ("-DARDUINO_ARCH_STM32",),
}
SWITCHES = {
    "serial": (),
    "USB": ("-DUSE_USBCON",),
    "TCP": ("-DROSSERIAL_ARDUINO_TCP",),
    "UDP": ("-DROSSERIAL_ARDUINO_UDP",),
    "TCP over Wi-Fi": ("-DROSSERIAL_ARDUINO_TCP", "-DROSSERIAL_ARDUINO_WIFI"),
}
# The network headers have no branches for the other boards.
SERIAL_ONLY = {"Due", "SAMD", "OpenCR", "Maple Mini", "STM32duino"}
ARDUINO_NODES = [
    (board, switch)
    for board in BOARDS
    for switch in SWITCHES
    if board not in SERIAL_ONLY or switch in ("serial", "USB")
]
AVRS = {
    "Uno": ("-mmcu=atmega328p", "standard"),
    "Mega": ("-mmcu=atmega2560", "mega"),
    "Leonardo": ("-mmcu=atmega32u4", "leonardo", "-DUSBCON", "-DUSB_VID=0x2341", "-DUSB_PID=0x8036"),
    "ATmega168": ("-mmcu=atmega168", "standard"),
}


def _compile(library: Path, command: tuple[str, ...], source: Path) -> str:
    completed = subprocess.run(
        [*command[:1], *WARNINGS, *command[1:], f"-I{library}/src", "-fsyntax-only", str(source)],
        capture_output=True,
        text=True,
    )
    assert completed.returncode == 0, completed.stderr
    return completed.stderr


@pytest.mark.arm
@pytest.mark.parametrize("kit", EMBEDDED)
def test_kits(library: Path, kit: str) -> None:
    assert not _compile(library, (*ARM, *EMBEDDED[kit]), NODE / "embedded.cpp")


@pytest.mark.arm
@pytest.mark.parametrize(("board", "switch"), ARDUINO_NODES)
def test_arduino_boards(library: Path, board: str, switch: str) -> None:
    assert not _compile(library, (*ARM, *ARDUINO, *BOARDS[board], *SWITCHES[switch]), NODE / "arduino.cpp")


@pytest.mark.arm
@pytest.mark.parametrize("board", ["ESP32", "Uno R4 WiFi"])
def test_a_robot_of_a_fleet(control_library: Path, board: str) -> None:
    sketch = ("-x", "c++", "-include", "Arduino.h")
    command = (*ARM, *ARDUINO, *BOARDS[board], *sketch)
    assert not _compile(control_library, command, EXAMPLES / "MulticastRobot" / "MulticastRobot.ino")


@pytest.mark.arm
def test_a_turtlebot3(tmp_path: Path) -> None:
    packages = ["diagnostic_msgs", "nav_msgs", "sensor_msgs", "std_msgs", "tf", "turtlebot3_msgs"]
    robots_library = write_library(tmp_path, Registry(), packages=packages).path
    core = (f"-I{client_library()}/extras/opencr_on_linux", "-DARDUINO=10819", "-D__OPENCR__")
    sketch = EXAMPLES / "TurtleBot3Burger" / "TurtleBot3Burger.ino"
    assert not _compile(robots_library, (*ARM, *core, "-x", "c++", "-include", "Arduino.h"), sketch)


@pytest.mark.arm
@pytest.mark.parametrize("flag", ["-DESP8266", "-DSTUB_UDP_WITHOUT_MULTICAST"])
def test_boards_with_other_multicast_interfaces(control_library: Path, tmp_path: Path, flag: str) -> None:
    source = tmp_path / "robot.cpp"
    source.write_text(
        "#include <Arduino.h>\n#include <WiFi.h>\n#include <arduino_control/ArduinoControl.h>\n"
        "#include <ros/multicast_command.h>\ntypedef arduino_control::ArduinoControl Control;\n"
        "void drive(const Control&) {}\nvoid halt() {}\n"
        "ros::MulticastCommand<Control, WiFiUDP> commands(&drive, &halt);\n"
        "void start() { commands.begin(IPAddress(239, 255, 82, 83), 11412); commands.spinOnce(); }\n"
    )
    assert not _compile(control_library, (*ARM, *ARDUINO, flag), source)


@pytest.mark.arm
@pytest.mark.parametrize(
    ("board", "switch"), [("Teensy", "USE_TEENSY_HW_SERIAL"), ("STM32duino", "USE_STM32_HW_SERIAL")]
)
def test_arduino_hardware_ports(library: Path, board: str, switch: str) -> None:
    assert not _compile(library, (*ARM, *ARDUINO, *BOARDS[board], f"-D{switch}"), NODE / "arduino.cpp")


@pytest.mark.avr
@pytest.mark.parametrize("switch", ["serial", "USB"])
@pytest.mark.parametrize("board", AVRS)
def test_avr_boards(library: Path, board: str, switch: str) -> None:
    mcu, variant, *macros = AVRS[board]
    command = ("avr-g++", "-Os", "-fno-exceptions", mcu, "-DF_CPU=16000000L", "-DARDUINO=10819", *macros)
    core = (f"-I{ARDUINO_CORE}/cores/arduino", f"-I{ARDUINO_CORE}/variants/{variant}")
    assert not _compile(library, (*command, *core, *SWITCHES[switch]), NODE / "arduino.cpp")


@pytest.mark.avr
@pytest.mark.parametrize("optimization", ["-O0", "-Og", "-Os"])
def test_avr_programs_for_debuggers_link(library: Path, tmp_path: Path, optimization: str) -> None:
    source = tmp_path / "main.cpp"
    source.write_text(
        "#include <ros/node_handle.h>\n"
        "struct Own { void init() {} int read() { return -1; } void write(uint8_t*, int) {}\n"
        "             unsigned long time() { return 0; } };\n"
        'extern "C" void __cxa_pure_virtual() {}\n'
        "ros::NodeHandle_<Own> nh;\nint main() { nh.initNode(); nh.spinOnce(); }\n"
    )
    command = ["avr-g++", "-std=gnu++11", optimization, "-mmcu=atmega328p", f"-I{library}/src"]
    subprocess.run([*command, "-o", str(tmp_path / "main.elf"), str(source)], check=True)


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(("g++", "-O2", "-Wpedantic"), marks=pytest.mark.gcc),
        pytest.param(("g++", "-O2", "-std=c++20"), marks=pytest.mark.gcc),
        pytest.param(("clang++", "-O2", "-std=c++11", "-Wpedantic"), marks=pytest.mark.clang),
        pytest.param(("x86_64-w64-mingw32-g++", "-std=c++11"), marks=pytest.mark.mingw),
    ],
    ids=" ".join,
)
def test_operating_systems(library: Path, command: tuple[str, ...]) -> None:
    ports = (
        ("WindowsHardware", "WindowsCom") if "mingw" in command[0] else ("EmbeddedLinuxHardware", "PosixTty")
    )
    for port in ports:
        chosen = f"-DPLATFORM_NODE_HANDLE=ros::NodeHandle_<{port}>"
        assert not _compile(library, (*command, chosen), NODE / "host.cpp")


@pytest.mark.arm
def test_an_unknown_system_gets_a_hint(library: Path, tmp_path: Path) -> None:
    source = tmp_path / "main.cpp"
    source.write_text("#include <ros.h>\n")
    with pytest.raises(AssertionError, match="define ROS_NO_PLATFORM and give ros::NodeHandle_ a Hardware"):
        _compile(library, ARM, source)
    source.write_text(
        "#define ROS_NO_PLATFORM\n#include <ros.h>\n"
        "struct Own { void init() {} int read() { return -1; } void write(uint8_t*, int) {}\n"
        "             unsigned long time() { return 0; } };\n"
        "ros::NodeHandle_<Own> nh;\nvoid start() { nh.initNode(); nh.spinOnce(); }\n"
    )
    assert not _compile(library, ARM, source)

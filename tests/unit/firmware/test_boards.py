from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.firmware.boards import BoardTable, other_platform_fqbn
from rostether.firmware.build import find_board

BOARDS_TXT = """
menu.cpu=Processor
uno.name=Arduino UNO
uno.upload_port.0.vid=0x2341
uno.upload_port.0.pid=0x0043
uno.upload.protocol=arduino
uno.upload.maximum_size=32256
uno.upload.maximum_data_size=2048
uno.upload.speed=115200
uno.build.mcu=atmega328p
uno.build.f_cpu=16000000L
nano.name=Arduino Nano
nano.upload.protocol=arduino
nano.build.f_cpu=16000000L
nano.menu.cpu.atmega328=ATmega328P
nano.menu.cpu.atmega328.upload.speed=115200
nano.menu.cpu.atmega328.build.mcu=atmega328p
nano.menu.cpu.atmega328old=ATmega328P (Old Bootloader)
nano.menu.cpu.atmega328old.upload.speed=57600
nano.menu.cpu.atmega328old.build.mcu=atmega328p
"""


@pytest.fixture
def table() -> BoardTable:
    return BoardTable(BOARDS_TXT)


@pytest.mark.parametrize("name", ["uno", "Uno", "UNO", "Arduino Uno", "arduino:avr:uno", "uno-r3"])
def test_the_uno_by_its_names(table: BoardTable, name: str) -> None:
    board = table.find(name)
    assert (board.mcu, board.flash_bytes, board.ram_bytes) == ("atmega328p", 32256, 2048)
    assert board.fqbn == "arduino:avr:uno"
    assert board.usb_ids == ((0x2341, 0x0043),)


@pytest.mark.parametrize(
    ("name", "speed"),
    [
        ("nano", 115200),
        ("nano:atmega328old", 57600),
        ("nano:cpu=atmega328old", 57600),
        ("arduino:avr:nano:cpu=atmega328old", 57600),
        ("nano-old", 57600),
    ],
)
def test_the_processor_chooses_a_variant_of_a_board(table: BoardTable, name: str, speed: int) -> None:
    assert table.find(name).upload_speed_baud == speed


def test_an_unknown_board_names_similar_ones(table: BoardTable) -> None:
    with pytest.raises(ConfigError, match=r"no board 'unno'; did you mean uno"):
        table.find("unno")


def test_a_board_without_similar_names_lists_the_usual_ones(table: BoardTable) -> None:
    with pytest.raises(
        ConfigError, match=r"no board 'zzzz'; known: uno, nano, promini, opencr, .* every FQBN"
    ):
        table.find("zzzz")


def test_an_unknown_processor_names_the_known_ones(table: BoardTable) -> None:
    with pytest.raises(ConfigError, match="it has atmega328, atmega328old"):
        table.find("nano:atmega644")


def test_other_platforms_are_left_to_arduino_cli() -> None:
    assert other_platform_fqbn("esp32:esp32:esp32") == "esp32:esp32:esp32"
    assert other_platform_fqbn("OpenCR") == "OpenCR:OpenCR:OpenCR"
    assert other_platform_fqbn("Uno R4 WiFi") == "arduino:renesas_uno:unor4wifi"
    assert other_platform_fqbn("ESP8266") == "esp8266:esp8266:generic"
    assert other_platform_fqbn("Pico W") == "rp2040:rp2040:rpipicow"
    assert other_platform_fqbn("arduino:avr:uno") is None
    assert other_platform_fqbn("nano:atmega328old") is None
    assert not find_board("esp32:esp32:esp32").is_avr
    assert find_board("opencr").fqbn == "OpenCR:OpenCR:OpenCR"


@pytest.mark.avr
@pytest.mark.parametrize(
    ("name", "mcu", "flash_bytes", "ram_bytes", "protocol", "needs_touch"),
    [
        ("uno", "atmega328p", 32256, 2048, "arduino", False),
        ("mega", "atmega2560", 253952, 8192, "wiring", False),
        ("mega1280", "atmega1280", 126976, 8192, "arduino", False),
        ("leonardo", "atmega32u4", 28672, 2560, "avr109", True),
        ("micro", "atmega32u4", 28672, 2560, "avr109", True),
        ("nano", "atmega328p", 30720, 2048, "arduino", False),
        ("promini", "atmega328p", 30720, 2048, "arduino", False),
        ("promini8", "atmega328p", 30720, 2048, "arduino", False),
        ("mini", "atmega328p", 28672, 2048, "arduino", False),
    ],
)
def test_the_boards_of_the_installed_core(
    name: str, mcu: str, flash_bytes: int, ram_bytes: int, protocol: str, needs_touch: bool
) -> None:
    board = find_board(name)
    assert (board.mcu, board.flash_bytes, board.ram_bytes) == (mcu, flash_bytes, ram_bytes)
    assert (board.upload_protocol, board.needs_touch) == (protocol, needs_touch)


@pytest.mark.avr
def test_the_slow_pro_mini_runs_at_half_the_speed() -> None:
    speeds = [find_board(name).properties["build.f_cpu"] for name in ("promini8", "promini")]
    assert speeds == ["8000000L", "16000000L"]

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.codegen.library_source import client_library
from rostether.errors import ConfigError, InvalidNameError
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.new_sketch import KINDS, write_sketch

EXAMPLES = client_library() / "examples"


def test_pins_and_topic_are_in_the_code_and_in_the_wiring(tmp_path: Path) -> None:
    # The pins are exchanged: each must be replaced only once.
    file = write_sketch(
        tmp_path / "front", KINDS["ultrasound"], EXAMPLES, {"TRIG": "5", "ECHO": "6"}, "front/range"
    )
    assert file == tmp_path / "front" / "front.ino"
    text = file.read_text()
    assert "const int TRIG = 5;\nconst int ECHO = 6;\n" in text
    assert 'ros::Publisher pub_range("front/range", &range_msg);' in text
    assert "Trig - pin 5, Echo - pin 6." in text
    assert "rostether topic echo /front/range" in text
    assert text.startswith(
        '// front: the distance that an HC-SR04 measures, 20 times a second on the topic "fr'
    )


@pytest.mark.avr
@pytest.mark.parametrize("kind", list(KINDS))
async def test_every_kind_builds_and_matches_its_table(tmp_path: Path, kind: str) -> None:
    described = KINDS[kind]
    pins = {name: f"A{number + 1}" for number, name in enumerate(described.pins)}
    file = write_sketch(tmp_path / kind, described, EXAMPLES, pins, "my_topic")
    text = file.read_text()
    assert all(f"const int {name} = {pin};" in text for name, pin in pins.items())
    assert '("my_topic", &' in text
    assert (await build_sketch(file, find_board("uno"))).elf.is_file()


@pytest.mark.parametrize(
    ("pins", "reason"),
    [
        ({"TRIG": "x"}, "write a pin as a number"),
        ({"LED": "3"}, "no pin 'LED'; this sensor has TRIG, ECHO"),
        ({"TRIG": "5"}, "two different pins"),
    ],
)
def test_invalid_pins_are_refused(tmp_path: Path, pins: dict[str, str], reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        write_sketch(tmp_path / "a", KINDS["ultrasound"], EXAMPLES, pins, "x")
    assert not (tmp_path / "a").exists()


def test_other_invalid_arguments_are_refused(tmp_path: Path) -> None:
    kind = KINDS["temperature"]
    with pytest.raises(ConfigError, match="needs an analog pin"):
        write_sketch(tmp_path / "a", kind, EXAMPLES, {"SENSOR": "3"}, "x")
    with pytest.raises(ConfigError, match="cannot be a sketch's name"):
        write_sketch(tmp_path / "1-a", kind, EXAMPLES, {}, "x")
    with pytest.raises(InvalidNameError):
        write_sketch(tmp_path / "a", kind, EXAMPLES, {}, 'x", &y); //')
    write_sketch(tmp_path / "a", kind, EXAMPLES, {}, "x")
    with pytest.raises(ConfigError, match="exists; choose another name"):
        write_sketch(tmp_path / "a", kind, EXAMPLES, {}, "x")

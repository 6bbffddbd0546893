"""The sources of the examples: all are listed and tested, and their comments are correct."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from firmware.examples.stage import EXAMPLES, build_example
from rostether.firmware.footprint import measure

NAMES = sorted(folder.name for folder in EXAMPLES.iterdir())
# Not for AVR boards: tests/firmware/platforms builds and runs it.
FOR_OPENCR = {"TurtleBot3Burger"}


def test_each_example_has_a_sketch_and_a_test() -> None:
    tests = "".join(each.read_text() for each in Path(__file__).parent.glob("test_*.py"))
    for name in NAMES:
        assert (EXAMPLES / name / f"{name}.ino").is_file()
    for name in set(NAMES) - FOR_OPENCR:
        assert re.search(rf'running(_alone)?\("{name}"', tests)


@pytest.mark.parametrize("name", NAMES)
def test_each_begins_with_its_purpose_its_wiring_and_a_command(name: str) -> None:
    text = (EXAMPLES / name / f"{name}.ino").read_text()
    assert text.startswith(f"// {name}: ")
    assert re.search(r"^// Wiring:  ?\S", text, re.MULTILINE)
    assert re.search(r"^// Try it:  rostether ", text, re.MULTILINE)
    assert max(map(len, text.splitlines())) <= 120
    for typed in re.findall(r"rostether (?:topic pub|topic echo|service call)[^\n]*? /(\w+)", text):
        assert typed in ("tf", "rosout") or f'"{typed}"' in text, f"{name} has no topic {typed}"


def test_sketches_that_share_a_sensor_share_its_text() -> None:
    # With Arduino, two sketches cannot share a file.
    assert (EXAMPLES / "IMU/Mpu9150.h").read_text() == (EXAMPLES / "MobileBase/Mpu9150.h").read_text()


@pytest.mark.parametrize("name", sorted(set(NAMES) - FOR_OPENCR))
async def test_each_builds_without_a_warning_and_fits(name: str, kind: str) -> None:
    built = await build_example(name, kind)
    assert built.output == ""
    # The Mega has four times the RAM of an Uno.
    if kind == "uno":
        footprint = await measure(built.elf, built.board)
        assert footprint.refusals() == []
        assert footprint.warnings() == []


@pytest.mark.parametrize("name", NAMES)
def test_the_reference_lists_the_topics_and_types_of_each_example(name: str) -> None:
    table = (EXAMPLES.parents[1] / "docs" / "reference" / "examples.md").read_text()
    (row,) = [line for line in table.splitlines() if line.startswith(f"| {name} |")]
    text = (EXAMPLES / name / f"{name}.ino").read_text()
    named = re.findall(r"`([a-z_]+)` (\w+)/(\w+)", row)
    for topic, package, message in named:
        assert f'"{topic}"' in text
        assert f"#include <{package}/{message}.h>" in text
    # The table has everything that the sketch has.
    declared = re.findall(r'(?:Publisher|Subscriber|Service\w+)(?:<[^;{]*>)? \w+\("([a-z_]+)"', text)
    assert set(declared) <= {topic for topic, _, _ in named}

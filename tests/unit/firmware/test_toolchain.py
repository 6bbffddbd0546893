from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import FirmwareError
from rostether.firmware.build import find_board
from rostether.firmware.toolchain import find_arduino_cli, find_avr_toolchain

INSTALL = "sudo apt install gcc-avr avr-libc arduino-core-avr"


def test_a_missing_compiler_is_reported_with_what_to_type(tmp_path: Path) -> None:
    with pytest.raises(FirmwareError, match=f"no AVR compiler .*; run: {INSTALL}"):
        find_avr_toolchain({"PATH": str(tmp_path)})


def test_a_missing_core_is_reported_with_what_to_type(tmp_path: Path) -> None:
    compiler = tmp_path / "avr-g++"
    compiler.write_text("#!/bin/sh\n")
    compiler.chmod(0o755)
    with pytest.raises(FirmwareError, match=f"no Arduino core .*; run: {INSTALL}"):
        find_avr_toolchain({"PATH": str(tmp_path)}, (str(tmp_path / "nowhere"),))


def test_a_missing_arduino_cli_is_reported_with_its_reason(tmp_path: Path) -> None:
    with pytest.raises(FirmwareError, match="building for an ESP32 needs arduino-cli"):
        find_arduino_cli("building for an ESP32", {"PATH": str(tmp_path)})


@pytest.mark.avr
def test_recipes_are_those_of_the_core() -> None:
    recipe = find_avr_toolchain().recipe("cpp.o", find_board("leonardo"))
    for flag in ("-Os", "-flto", "-std=gnu++11", "-mmcu=atmega32u4", "-DF_CPU=16000000L", "-DARDUINO=10819"):
        assert flag in recipe
    assert '-DUSB_PRODUCT="Arduino Leonardo"' in recipe
    assert "-DDECIMAL_DIG=__DECIMAL_DIG__" in recipe
    assert "-w" in recipe


@pytest.mark.avr
def test_warnings_have_the_options_of_the_ide() -> None:
    recipe = find_avr_toolchain().recipe("cpp.o", find_board("uno"), "all")
    assert "-Wextra" in recipe
    assert "-w" not in recipe

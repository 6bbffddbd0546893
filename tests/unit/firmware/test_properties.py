from __future__ import annotations

from rostether.firmware.properties import command_line, expand, parse_properties


def test_comments_empty_lines_and_lines_without_a_value_are_skipped() -> None:
    assert parse_properties("# a=b\n\nuno.name = Arduino UNO\nnonsense\nx=a=b") == {
        "uno.name": "Arduino UNO",
        "x": "a=b",
    }


def test_values_are_expanded_also_inside_of_values() -> None:
    properties = {"cmd": "{path}/avr-gcc", "path": "/usr/bin", "build.mcu": "atmega328p"}
    assert (
        expand("{cmd} -mmcu={build.mcu} {unknown}", properties)
        == "/usr/bin/avr-gcc -mmcu=atmega328p {unknown}"
    )


def test_keys_that_name_each_other_do_not_hang() -> None:
    assert expand("{a}", {"a": "{b}", "b": "{a}"}) in ("{a}", "{b}")


def test_quotes_hold_an_argument_together() -> None:
    recipe = """"{cmd}" '-DUSB_PRODUCT={name}' "{source_file}" """
    arguments = command_line(recipe, {"cmd": "gcc", "name": '"Arduino Leonardo"'})
    assert arguments == ["gcc", '-DUSB_PRODUCT="Arduino Leonardo"', "{source_file}"]

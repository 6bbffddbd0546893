from __future__ import annotations

from rostether.firmware.properties import command_line, expand, parse_properties


def test_comments_empty_lines_and_lines_without_a_value_are_skipped() -> None:
    assert parse_properties("# a=b\n\nuno.name = Arduino UNO\nnonsense\nx=a=b") == {
        "uno.name": "Arduino UNO",
        "x": "a=b",
    }


def test_nested_values_are_expanded() -> None:
    properties = {"cmd": "{path}/avr-gcc", "path": "/usr/bin", "build.mcu": "atmega328p"}
    assert (
        expand("{cmd} -mmcu={build.mcu} {unknown}", properties)
        == "/usr/bin/avr-gcc -mmcu=atmega328p {unknown}"
    )


def test_keys_that_refer_to_each_other_end() -> None:
    assert expand("{a}", {"a": "{b}", "b": "{a}"}) in ("{a}", "{b}")


def test_quotes_enclose_one_argument() -> None:
    recipe = """"{cmd}" '-DUSB_PRODUCT={name}' "{source_file}" """
    arguments = command_line(recipe, {"cmd": "gcc", "name": '"Arduino Leonardo"'})
    assert arguments == ["gcc", '-DUSB_PRODUCT="Arduino Leonardo"', "{source_file}"]

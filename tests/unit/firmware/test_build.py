from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import Any

import pytest

from rostether.errors import ConfigError, SketchError
from rostether.firmware.build import build_sketch, find_board, save_outputs
from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
from rostether.firmware.elf import ElfFile
from unit.firmware.sketches import EMPTY, uno, write_sketch

pytestmark = pytest.mark.avr

HELLO = """
#include <ros.h>
#include <std_msgs/String.h>
#include <std_msgs/Empty.h>

ros::NodeHandle nh;
std_msgs::String message;
ros::Publisher chatter("chatter", &message);
ros::Subscriber<std_msgs::Empty> toggle("toggle", &on_toggle);

void setup() { nh.initNode(); nh.advertise(chatter); nh.subscribe(toggle); }
void on_toggle(const std_msgs::Empty&) { digitalWrite(13, !digitalRead(13)); }
void loop() { message.data = "hello"; chatter.publish(&message); nh.spinOnce(); }
"""


async def build(sketch: Path, board: str = "uno", **options: Any) -> BuiltFirmware:
    return await build_sketch(sketch, find_board(board), BuildOptions(**options))


async def refuse(sketch: Path, **options: Any) -> SketchError:
    with pytest.raises(SketchError) as caught:
        await build(sketch, **options)
    return caught.value


def functions(built: BuiltFirmware) -> set[str]:
    return {each.name for each in ElfFile.read(built.elf).symbols}


@pytest.mark.parametrize("board", ["uno", "mega", "leonardo", "nano", "micro", "promini8"])
async def test_an_empty_sketch_for_each_board(tmp_path: Path, board: str) -> None:
    built = await build(write_sketch(tmp_path, "Empty", EMPTY), board)
    assert built.elf.name == "Empty.elf"
    assert built.image.read_text().startswith(":10")


async def test_an_empty_sketch_with_serial_is_as_small_as_in_the_ide(tmp_path: Path) -> None:
    built = await build(
        write_sketch(tmp_path, "Serial", "void setup() { Serial.begin(9600); }\nvoid loop() {}")
    )
    elf = ElfFile.read(built.elf)
    assert elf.flash_bytes <= 1482
    assert elf.ram_bytes <= 184


async def test_the_files_of_a_sketch_are_one_program(tmp_path: Path) -> None:
    sketch = write_sketch(
        tmp_path,
        "Robot",
        '#include "arm.h"\nvoid setup() { later(arm()); }\nvoid loop() { deep(); }\n',
        {
            "arm.h": "int arm();\n",
            "arm.cpp": '#include "arm.h"\nint arm() { return 3; }\n',
            "b_second.ino": "#include <EEPROM.h>\r\nvoid later(int a) { EEPROM.write(1, a); }\r\n",
            "src/deep/deep.c": "volatile int depth; void deep(void) { depth++; }\n",
            "c_third.ino": 'extern "C" void deep(void);\n',
        },
    )
    (sketch / "Robot.ino").write_text('extern "C" void deep(void);\n' + (sketch / "Robot.ino").read_text())
    built = await build(sketch)
    assert "depth" in functions(built)
    assert [each.name for each in built.libraries] == ["EEPROM"]


async def test_libraries_bring_their_sources_and_the_libraries_of_these(tmp_path: Path) -> None:
    libraries = tmp_path / "libraries"
    write_sketch(
        libraries,
        "Outer",
        "",
        {"src/Outer.h": "void outer();", "src/Outer.cpp": "#include <Inner.h>\nvoid outer() { inner(); }"}
        | {"library.properties": "name=Outer\n"},
    )
    write_sketch(
        libraries,
        "Inner",
        "",
        {"Inner.h": "void inner();", "Inner.cpp": "#include <Wire.h>\nvoid inner() { Wire.begin(); }"},
    )
    sketch = write_sketch(tmp_path, "S", "#include <Outer.h>\nvoid setup() { outer(); }\nvoid loop() {}\n")
    built = await build(sketch, libraries=(libraries,))
    assert sorted(each.name for each in built.libraries) == ["Inner", "Outer", "Wire"]
    assert "twi_init" in functions(built)


async def test_the_sketchbook_is_searched(tmp_path: Path) -> None:
    write_sketch(tmp_path / "Arduino" / "libraries", "Mine", "", {"Mine.h": "#define MINE 1\n"})
    built = await build(write_sketch(tmp_path, "S", "#include <Mine.h>\nint a = MINE;\n" + EMPTY))
    assert [each.name for each in built.libraries] == ["Mine"]


async def test_headers_that_are_not_included_bring_no_library(tmp_path: Path) -> None:
    sketch = write_sketch(tmp_path, "S", "#ifdef ESP32\n#include <Servo.h>\n#endif\n" + EMPTY)
    assert (await build(sketch)).libraries == ()


async def test_a_loose_file_is_built_with_the_sources_of_its_headers_only(tmp_path: Path) -> None:
    (tmp_path / "blink.ino").write_text('#include "mine.h"\nvoid setup() { mine(); }\nvoid loop() {}\n')
    (tmp_path / "mine.h").write_text("void mine();\n")
    (tmp_path / "mine.cpp").write_text("volatile int used; void mine() { used = 1; }\n")
    (tmp_path / "stranger.cpp").write_text("this is no C++\n")
    assert "used" in functions(await build(tmp_path / "blink.ino"))


async def test_a_cpp_file_is_compiled_unchanged(tmp_path: Path) -> None:
    (tmp_path / "main.cpp").write_text("#include <Arduino.h>\nvoid setup() { }\nvoid loop() { }\n")
    assert (await build(tmp_path / "main.cpp")).elf.exists()


async def test_errors_contain_the_users_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sketch = write_sketch(
        tmp_path,
        "Bad",
        "void setup() {\n  later();\n  nowhere = 1;\n}\nvoid loop() {}\nint later() { return +; }\n",
        {"other.cpp": "int f() { return ; ) }\n", "z.ino": "\n\nvoid z() { alsonowhere(); }\n"},
    )
    monkeypatch.chdir(tmp_path)
    error = await refuse(sketch)
    assert re.search(r"^Bad/Bad\.ino:3:3: error: .nowhere. was not declared", error.diagnostics, re.MULTILINE)
    assert re.search(r"^Bad/Bad\.ino:6:23: error: ", error.diagnostics, re.MULTILINE)
    assert re.search(r"^Bad/z\.ino:3:\d+: error: .alsonowhere. was not", error.diagnostics, re.MULTILINE)
    assert re.search(r"^Bad/other\.cpp:1:", error.diagnostics, re.MULTILINE)
    assert str(error) == "Bad does not build for uno: Bad.ino does not compile"


async def test_an_undefined_function_is_an_error_of_the_linker(tmp_path: Path) -> None:
    error = await refuse(write_sketch(tmp_path, "S", "void f();\nvoid setup() { f(); }\nvoid loop() {}\n"))
    # Newer linkers print the mangled name.
    assert re.search(r"undefined reference to `(f\(\)|_Z1fv)'", error.diagnostics)
    assert "S does not link" in str(error)


async def test_typographic_quotes_are_explained(tmp_path: Path) -> None:
    error = await refuse(write_sketch(tmp_path, "S", "#include \u201cros.h\u201d\n" + EMPTY))
    assert (
        "S.ino:1:10: error: \u201c (left double quotation mark) comes from a web page or PDF"
        in error.diagnostics
    )


@pytest.mark.parametrize(
    ("header", "note"),
    [
        ("Nowhere.h", "note: no library contains Nowhere.h; give the folder of the library with --library"),
        ("my_msgs/Thing.h", "note: no package contains my_msgs/Thing.h; give the folder of its package"),
        ("std_mgs/Empty.h", "note: no package contains std_mgs/Empty.h; did you mean std_msgs/Empty.h?"),
        ("WProgram.h", "note: this board has no WProgram.h: include <Arduino.h> instead"),
        ("ESP8266WiFi.h", "it belongs to the core of the ESP8266; build with --board esp8266"),
    ],
)
async def test_a_missing_header_is_reported_with_what_to_do(tmp_path: Path, header: str, note: str) -> None:
    error = await refuse(write_sketch(tmp_path, "S", f"#include <{header}>\n" + EMPTY))
    assert note in error.diagnostics


async def test_warnings_are_shown_on_request(tmp_path: Path) -> None:
    sketch = write_sketch(tmp_path, "S", "void setup() { int unused; }\nvoid loop() {}\n")
    assert (await build(sketch)).output == ""
    for _ in range(2):  # from the cache as well
        assert "S.ino:1:20: warning: unused variable" in (await build(sketch, warnings=True)).output


async def test_macros_can_be_defined(tmp_path: Path) -> None:
    sketch = write_sketch(tmp_path, "S", "#if SPEED != 3\n#error no speed\n#endif\n" + EMPTY)
    assert "no speed" in (await refuse(sketch)).diagnostics
    assert (await build(sketch, defines=("SPEED=3",))).elf.exists()


async def test_an_unchanged_sketch_is_not_built_again(tmp_path: Path) -> None:
    sketch = write_sketch(tmp_path, "S", EMPTY, {"local.h": "#define A 1\n"})
    (sketch / "S.ino").write_text('#include "local.h"\nvolatile int a = A;\n' + EMPTY)
    first = await build(sketch)
    commands: list[object] = []
    second = await build(sketch, show=commands.append)
    assert (second.elf, second.is_from_cache, commands) == (first.elf, True, [])
    (sketch / "local.h").write_text("#define A 2\n")
    third = await build(sketch)
    assert third.elf != first.elf
    (sketch / "local.h").write_text("#define A 1\n")
    assert (await build(sketch)).elf == first.elf


async def test_an_edit_costs_one_compilation(tmp_path: Path) -> None:
    sketch = write_sketch(tmp_path, "S", "volatile int a = 1;\n" + EMPTY)
    await build(sketch)
    (sketch / "S.ino").write_text("volatile int a = 2;\n" + EMPTY)
    compiled: list[str] = []
    await build(sketch, show=lambda command: compiled.append(command[-1]) if "-c" in command else None)
    assert len(compiled) == 1


async def test_a_new_file_in_the_folder_is_detected(tmp_path: Path) -> None:
    sketch = write_sketch(tmp_path, "S", EMPTY)
    await build(sketch)
    (sketch / "new.cpp").write_text("#error here I am\n")
    assert "here I am" in (await refuse(sketch)).diagnostics


async def test_two_builds_at_once_have_the_same_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    sketch = write_sketch(tmp_path, "S", EMPTY)
    first, second = await asyncio.gather(build(sketch), build(sketch))
    assert first.elf == second.elf
    assert ElfFile.read(first.elf).flash_bytes > 0


async def test_a_sketch_with_ros_gets_its_library(tmp_path: Path) -> None:
    built = await build(write_sketch(tmp_path, "Hello", HELLO))
    assert [each.name for each in built.libraries] == ["ros_lib"]


async def test_messages_of_the_user_are_generated_and_follow_their_definition(tmp_path: Path) -> None:
    package = tmp_path / "packages" / "my_robot" / "msg"
    package.mkdir(parents=True)
    (package / "Wheels.msg").write_text("float32 left\n")
    sketch = write_sketch(
        tmp_path,
        "S",
        "#include <my_robot/Wheels.h>\nmy_robot::Wheels w;\nvoid setup() { w.left = 1; }\nvoid loop() {}\n",
    )
    await build(sketch, msg_paths=(tmp_path / "packages",))
    (package / "Wheels.msg").write_text("float32 right\n")
    error = await refuse(sketch, msg_paths=(tmp_path / "packages",))
    assert "has no member named" in error.diagnostics


async def test_a_given_ros_library_has_priority(tmp_path: Path) -> None:
    write_sketch(tmp_path / "libs", "ros_lib", "", {"ros.h": "#define MINE 1\n"})
    sketch = write_sketch(tmp_path, "S", "#include <ros.h>\nint a = MINE;\n" + EMPTY)
    built = await build(sketch, libraries=(tmp_path / "libs",))
    assert [each.folder for each in built.libraries] == [tmp_path / "libs" / "ros_lib"]


async def test_a_missing_library_is_reported(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such folder"):
        await build(write_sketch(tmp_path, "S", EMPTY), libraries=(tmp_path / "nowhere",))


async def test_outputs_are_copied(tmp_path: Path) -> None:
    built = await build_sketch(write_sketch(tmp_path, "S", EMPTY), uno())
    elf, image = save_outputs(built, tmp_path / "deep" / "out")
    assert (elf.name, image.name) == ("S.elf", "S.hex")
    assert elf.read_bytes() == built.elf.read_bytes()


async def test_a_program_that_is_too_large_is_linked_too(tmp_path: Path) -> None:
    text = (
        "const uint8_t a[20000] PROGMEM = {1};\nconst uint8_t b[20000] PROGMEM = {1};\nvolatile int i;\n"
        "void setup() { i = pgm_read_byte(a + i) + pgm_read_byte(b + i); }\nvoid loop() {}\n"
    )
    built = await build(write_sketch(tmp_path, "Big", text))
    assert ElfFile.read(built.elf).flash_bytes > 40000


async def test_messages_of_the_package_that_the_sketch_is_in(tmp_path: Path) -> None:
    package = tmp_path / "arm_model"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>arm_model</name></package>")
    (package / "msg" / "Angles.msg").write_text("uint8 elbow\n")
    text = HELLO.replace("std_msgs/Empty", "arm_model/Angles").replace("std_msgs::Empty", "arm_model::Angles")
    built = await build(write_sketch(package, "Arm", text))
    assert built.elf.is_file()

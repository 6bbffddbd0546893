"""`firmware build`, `size` and `upload` as they are typed."""

from __future__ import annotations

import os
import pty
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from unit.cli.command_shell import Shell
from unit.firmware.programs import FakeProgram
from unit.firmware.sketches import EMPTY, users_cache, write_sketch
from unit.firmware.test_build import HELLO

pytestmark = pytest.mark.avr


@pytest.fixture(autouse=True)
def _own_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", users_cache())
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def port() -> Iterator[str]:
    leader, follower = pty.openpty()
    path = os.ttyname(follower)
    os.close(follower)
    yield path
    os.close(leader)


def test_build_reports_its_output_and_the_size(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Blink", EMPTY)
    lines = shell.output("firmware", "build", "Blink", "--output", "out").splitlines()
    assert re.fullmatch(
        r"Blink for Arduino UNO: \d+ of 32256 bytes \(\d+ %\) of flash, \d+ of 2048 bytes \(\d+ %\) of RAM",
        lines[0],
    )
    assert lines[1] == "  out/Blink.hex"
    assert (tmp_path / "out" / "Blink.elf").read_bytes()[:4] == b"\x7fELF"


def test_build_as_json(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Blink", EMPTY)
    shell.output("firmware", "build", "Blink", "--board", "mega")
    (record,) = shell("firmware", "build", "Blink", "--board", "mega", "--json").records
    assert record["board"] == "arduino:avr:mega:cpu=atmega2560"
    assert record["is_from_cache"] is True
    assert Path(record["image"]).name == "Blink.hex"
    assert (record["flash_limit_bytes"], record["ram_limit_bytes"]) == (253952, 8192)


def test_compile_errors_are_shown_in_the_words_of_the_compiler(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Bad", "void setup() { nowhere(); }\nvoid loop() {}\n")
    result = shell("firmware", "build", "Bad")
    assert result.code == 1
    assert re.search(r"^Bad/Bad\.ino:1:\d+: error: .nowhere. was not declared", result.err, re.MULTILINE)
    assert (
        result.err.splitlines()[-1]
        == "rostether: error: Bad does not build for uno: Bad.ino does not compile"
    )
    assert "Traceback" not in result.err


def test_warnings_are_on_request(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "S", "void setup() { int unused; }\nvoid loop() {}\n")
    assert "warning: unused variable" in shell("firmware", "build", "S", "--warnings").err
    assert shell("firmware", "build", "S").err == ""


def test_verbose_shows_every_command(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "S", EMPTY + "// only here\n")
    assert "avr-g++ -c -g -Os" in shell("firmware", "build", "S", "-v").err


def test_a_program_too_large_for_the_board_fails(shell: Shell, tmp_path: Path) -> None:
    write_sketch(
        tmp_path, "Big", "volatile char big[3000];\nvoid setup() { big[0] = big[1]; }\nvoid loop() {}\n"
    )
    line = shell.failure("firmware", "build", "Big")
    assert re.match(r"variables of \d+ bytes do not fit in the 2048 bytes of RAM of Arduino UNO", line)
    assert "the largest is big of your sketch (3000 bytes); see `rostether firmware size`" in line
    assert "big" in shell.output("firmware", "build", "Big", "--board", "mega").lower()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nowhere.ino",), "no sketch nowhere.ino; give an .ino file"),
        (("S", "--board", "unno"), "no board 'unno'; did you mean uno"),
        (("S", "--library", "nowhere"), "no such folder"),
        (("S", "--msg-path", "nowhere"), "no such folder"),
    ],
)
def test_usage_that_makes_no_sense_is_one_line(
    shell: Shell, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    write_sketch(tmp_path, "S", HELLO)
    assert message in shell.failure("firmware", "build", *arguments)


def test_size_names_the_parts_of_a_program(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Hello", HELLO)
    output = shell.output("firmware", "size", "Hello")
    assert max(map(len, output.splitlines())) <= 80
    for line in (
        r"Hello on Arduino UNO",
        r"flash +[\d,]+ +of 32,256 bytes .* \d+ %",
        r"RAM +[\d,]+ +of 2,048 bytes .* \d+ % \+ \d+ % stack",
        r"  stack, at most +\d+",
        r"  free +[\d,]+",
        r"ROS node +[\d,]+ +\d+ .*",
        r"your sketch +\d+ +\d+ .*",
        r"publishes +chatter +std_msgs/String +4 \+ contents +sent without a buffer",
        r"subscribes +toggle +std_msgs/Empty +0 +fits",
        r"Deepest stack: \d+ bytes in main.*",
    ):
        assert re.search(f"^{line}$", output, re.MULTILINE), line


def test_size_as_json(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Hello", HELLO)
    (record,) = shell("firmware", "size", "Hello", "--json").records
    assert record["fits"] is True
    assert record["flash_bytes"] == sum(each["flash_bytes"] for each in record["groups"])
    assert record["ram_bytes"] + record["stack_bytes"] + record["free_ram_bytes"] == record["ram_limit_bytes"]
    assert {each["topic"] for each in record["endpoints"]} == {"chatter", "toggle"}
    assert record["warnings"] == []


def test_size_warns_of_a_stack_that_may_not_fit(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Tight", HELLO + "volatile char big[1300];\nint touch() { return big[0]; }\n")
    text = (
        (tmp_path / "Tight" / "Tight.ino").read_text().replace("nh.initNode();", "nh.initNode(); big[1] = 1;")
    )
    (tmp_path / "Tight" / "Tight.ino").write_text("extern volatile char big[1300];\n" + text)
    result = shell("firmware", "size", "Tight")
    assert result.code == 0
    assert re.search(
        r"^WARNING: variables \(\d+ bytes\) and stack \(up to \d+\) leave -?\d+ of 2048", result.err
    )


def test_size_reports_a_message_that_cannot_be_received(shell: Shell, tmp_path: Path) -> None:
    text = HELLO.replace("std_msgs/Empty", "nav_msgs/Odometry").replace(
        "std_msgs::Empty", "nav_msgs::Odometry"
    )
    write_sketch(tmp_path, "Odom", text)
    result = shell("firmware", "size", "Odom")
    assert re.search(
        r"WARNING: toggle: nav_msgs/Odometry has 700 bytes and never arrives: the buffer has", result.err
    )


def test_size_fails_with_the_reason_if_it_does_not_fit(shell: Shell, tmp_path: Path) -> None:
    write_sketch(
        tmp_path, "Big", "volatile char big[3000];\nvoid setup() { big[0] = big[1]; }\nvoid loop() {}\n"
    )
    result = shell("firmware", "size", "Big")
    assert result.code == 1
    assert "your sketch" in result.out
    assert "variables of" in result.err


def test_size_of_a_program_built_elsewhere(shell: Shell, tmp_path: Path) -> None:
    write_sketch(tmp_path, "Hello", HELLO)
    shell.output("firmware", "build", "Hello", "--output", "out")
    assert "ROS node" in shell.output("firmware", "size", "out/Hello.elf")


def test_upload_builds_and_flashes(
    shell: Shell, tmp_path: Path, port: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bin").mkdir()
    avrdude = FakeProgram(tmp_path / "bin", "avrdude", monkeypatch)
    write_sketch(tmp_path, "Blink", EMPTY)
    lines = shell.output("firmware", "upload", "Blink", "--port", port).splitlines()
    assert lines[0].startswith(f"flashing Arduino UNO on {port}: ")
    assert lines[1] == "done; the board now runs the sketch"
    assert len(avrdude.calls) == 1


def test_upload_reports_a_missing_port_or_sketch_before_it_builds(
    shell: Shell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bin").mkdir()
    write_sketch(tmp_path, "Broken", "this does not compile")
    FakeProgram(tmp_path / "bin", "avrdude", monkeypatch)
    assert "no serial port /dev/nowhere" in shell.failure(
        "firmware", "upload", "Broken", "--port", "/dev/nowhere"
    )
    failure = shell.failure("firmware", "upload", ".", "--port", "/dev/nowhere")
    assert "contains no .ino or .cpp file; give the folder" in failure


def test_upload_flashes_nothing_that_does_not_fit(
    shell: Shell, tmp_path: Path, port: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bin").mkdir()
    avrdude = FakeProgram(tmp_path / "bin", "avrdude", monkeypatch)
    write_sketch(
        tmp_path, "Big", "volatile char big[3000];\nvoid setup() { big[0] = big[1]; }\nvoid loop() {}\n"
    )
    assert "do not fit" in shell.failure("firmware", "upload", "Big", "--port", port)
    assert avrdude.calls == []


@pytest.mark.simavr
def test_sim_builds_and_runs_on_a_simulated_board(shell: Shell, tmp_path: Path) -> None:
    write_sketch(
        tmp_path,
        "Blink",
        "void setup() { pinMode(13, OUTPUT); digitalWrite(13, ON); }\nvoid loop() {}\n",
    )
    result = shell("firmware", "sim", "Blink", "-D", "ON=HIGH", "--watch", "D13", "--fast", "--for", "20ms")
    assert result.code == 0, result
    assert not [line for line in result.err.splitlines() if "preparing a simulated uno" not in line]
    assert re.search(r"pin D13 .*1", result.out)

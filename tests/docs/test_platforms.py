"""The table of platforms names existing tests, and the programs on the pages of platforms compile."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from firmware.platforms.programs import STUBS
from rostether.codegen.arduino_library import write_library
from rostether.msgdef.registry import Registry

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "reference" / "platforms.md"


@pytest.fixture(scope="module")
def text_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client library with std_msgs."""
    return write_library(tmp_path_factory.mktemp("library"), Registry(), packages=["std_msgs"]).path


def test_each_platform_has_a_test() -> None:
    section = PAGE.read_text().partition("## Tests of each platform")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("| ")][2:]
    assert len(rows) >= 14
    for row in rows:
        match = re.search(r"\| `(tests/[\w/]+\.py)::(test_\w+)` \|$", row)
        assert match is not None, row
        assert re.search(rf"^(async )?def {match[2]}\(", (ROOT / match[1]).read_text(), re.MULTILINE), row


@pytest.mark.arm
@pytest.mark.parametrize(
    ("page", "flags"),
    [
        ("stm32", ("-DUSE_HAL_DRIVER", f"-I{STUBS}/stm32")),
        ("tiva-c", ("-DPART_TM4C123GH6PM", f"-I{STUBS}/tivaware")),
        ("mbed", ("-D__MBED__", f"-I{STUBS}/mbed6")),
        ("wifi-boards", ("-DARDUINO=10819", "-DESP32", f"-I{STUBS}/arduino")),
    ],
)
def test_the_program_of_a_page_compiles(page: str, flags: tuple[str, ...], text_library: Path) -> None:
    text = (ROOT / "docs" / "how-to" / "platforms" / f"{page}.md").read_text()
    code = re.search(r"```cpp[^\n]*\n(.*?)```", text, re.DOTALL)
    assert code is not None
    command = ("arm-none-eabi-g++", "-std=gnu++14", "-mcpu=cortex-m4", "-mthumb", "-fno-exceptions", "-Wall")
    completed = subprocess.run(
        [*command, *flags, f"-I{text_library}/src", "-fsyntax-only", "-x", "c++", "-"],
        input=code[1],
        capture_output=True,
        text=True,
    )
    assert not completed.stderr, completed.stderr

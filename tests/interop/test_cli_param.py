"""`rostether param` compared with rosparam."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import pytest
import pytest_asyncio

from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from interop.side_by_side import Output, SideBySide

PARAMETERS = """\
number: 1
float: 2.5
exponent: 1.0e+20
text_with_digits: '5'
text: "with: colon"
empty: ''
flag: true
multi: |
  line one
  line two
long: lorem ipsum dolor sit amet consectetur adipiscing elit sed do eiusmod tempor incididunt ut labore et
tab: "a\\tb"
unicode: "äö€ \\U0001F600"
list: [1, 2.5, x, [true, '']]
structs: [{x: 1}, {y: [1, 2]}]
space: {below: {deeper: -7}, other: no number}
degrees: deg(90)
radians: rad(pi/2)
tagged: [!degrees 45, !radians 2*pi]
---
_ns: second
gain: 3
"""


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


async def test_reading_prints_the_same(stage: Stage, tmp_path: Path) -> None:
    tools = SideBySide(stage.peers)
    file = tmp_path / "parameters.yaml"
    file.write_text(PARAMETERS)
    await tools.assert_same("rosparam", "load", str(file), "/board")

    listed, *_ = await tools.assert_all_same(
        "rosparam",
        ("list",),
        ("list", "board/space"),
        ("get", "/"),
        # A single value ends differently from a tree.
        ("get", "/board/number"),
        ("get", "/board/multi"),
        ("get", "/board/long"),
        ("get", "/board/list"),
        ("get", "-p", "/board"),
        ("get", "-p", "/board/multi"),
    )
    assert "/board/space/below/deeper" in listed.splitlines()


@ON_BOTH_MASTERS
async def test_writing_sets_the_same(stage: Stage, tmp_path: Path) -> None:
    tools = SideBySide(stage.peers)
    file = tmp_path / "parameters.yaml"
    file.write_text(PARAMETERS)

    async def write(run: Callable[..., Awaitable[Output]], namespace: str) -> str:
        steps: tuple[tuple[str, ...], ...] = (
            ("load", str(file), namespace),
            ("set", f"{namespace}/negative", "-5"),
            ("set", f"{namespace}/space", "{below: {deeper: 8}, new: [deg(180)]}"),
            ("set", f"{namespace}/empty_text", ""),
            ("set", f"{namespace}/quoted", "'5'"),
            ("set", f"{namespace}/file", "-t", str(file)),
            ("delete", f"{namespace}/second"),
            ("dump", str(tmp_path / f"{namespace}.yaml"), namespace),
        )
        for step in steps:
            output = await run("rosparam", *step)
            assert (output.code, output.out, output.err) == (0, "", "")
        return (tmp_path / f"{namespace}.yaml").read_text()

    rostether, debian = await asyncio.gather(
        write(tools.run_rostether, "rostether"), write(tools.run_debian, "debian")
    )
    assert rostether == debian
    assert "negative: -5" in rostether


async def test_both_set_bytes(stage: Stage, tmp_path: Path) -> None:
    # Debian's rosparam cannot print them.
    tools = SideBySide(stage.peers)
    file = tmp_path / "picture.bin"
    file.write_bytes(bytes(range(256)))
    for run in (tools.run_rostether, tools.run_debian):
        assert (await run("rosparam", "set", "/picture", "-b", str(file))).code == 0
        printed = (await tools.run_rostether("rosparam", "get", "/picture")).out
        assert printed.startswith("!!binary |\n  AAECAwQF")


async def test_invalid_commands_fail_in_both(stage: Stage) -> None:
    tools = SideBySide(stage.peers)
    assert "did you mean /rosversion?" in await tools.assert_both_fail("rosparam", "get", "/rosversio")
    for arguments in (
        ("delete", "/nothing"),
        ("set", "/", "5"),
        ("set", "/big", "5000000000"),
        ("load", "/no/file"),
    ):
        await tools.assert_both_fail("rosparam", *arguments)

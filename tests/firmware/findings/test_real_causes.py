"""Findings and their real causes: firmware with the fault, or a board on which it occurs.

Each test examines several boards at once, to save time. The tests of the command check the findings about
ports (permission, a port in use, no such port), so they are not here.
"""

from __future__ import annotations

import asyncio
from pathlib import Path

from firmware.findings import faulty_sketches as sketches
from firmware.findings.examining import Case, examine_all
from rostether.bridge.findings.finding import Code, Finding
from rostether.bridge.health.doctor import Diagnosis
from rostether.simulation.simavr.simulated_board import SimulatedBoard

ARM = "my_robot/msg/Arm.msg"


def only_finding(diagnosis: Diagnosis) -> Finding:
    (finding,) = diagnosis.findings
    return finding


async def switch_off(board: SimulatedBoard) -> None:
    await board.power(False)


async def drop_supply_voltage(board: SimulatedBoard) -> None:
    """A motor starts repeatedly, and each time the supply voltage drops."""
    while True:
        await asyncio.sleep(2.0)
        await board.power(False)
        await asyncio.sleep(0.2)
        await board.power(True)


async def unplug(board: SimulatedBoard) -> None:
    await asyncio.sleep(2.0)
    await board.close()


async def test_boards_without_rosserial(tmp_path: Path) -> None:
    found = await examine_all(
        {
            "healthy": Case(sketches.HEALTHY),
            "mute": Case(sketches.SENDS_NOTHING),
            "off": Case(sketches.HEALTHY, action=switch_off),
            "prints": Case(sketches.PRINTS),
            "noise": Case(sketches.SENDS_NOISE),
            "unplugged": Case(sketches.HEALTHY, action=unplug),
            "old": Case(sketches.PROTOCOL_VERSION_1),
            "new": Case(sketches.UNKNOWN_PROTOCOL_VERSION),
        },
        tmp_path,
        {
            "healthy": [],
            "mute": [Code.NOTHING_RECEIVED],
            "off": [Code.NOTHING_RECEIVED],
            "prints": [Code.TEXT_RECEIVED],
            "noise": [Code.NOISE_RECEIVED],
            "unplugged": [Code.CONNECTION_LOST],
            "old": [Code.PROTOCOL_VERSION],
            "new": [Code.PROTOCOL_VERSION],
        },
    )
    assert "'Temperature: " in only_finding(found["prints"]).seen
    assert "version 1" in only_finding(found["old"]).seen
    assert "version byte 0xfc" in only_finding(found["new"]).seen


async def test_sketches_with_another_baud_rate(tmp_path: Path) -> None:
    bauds = {"slow": 9600, "fast": 115200, "fastest": 1000000}
    cases = {
        name: Case(sketches.USES_115200_BAUD.replace("115200", str(baud)), baud=baud)
        for name, baud in bauds.items()
    }
    found = await examine_all(cases, tmp_path, {name: [Code.WRONG_BAUD] for name in bauds})
    for name, baud in bauds.items():
        finding = only_finding(found[name])
        assert f"uses {baud} baud, not 57600" in finding.seen
        assert f"?baud={baud}" in finding.next_step
        assert found[name].board is not None


async def test_sketches_with_faults(tmp_path: Path) -> None:
    old, new = "float32 angle\nfloat32 speed\n", "float32 angle\nfloat32 speed\nfloat32 torque\n"
    found = await examine_all(
        {
            "text": Case(sketches.PRINTS_BESIDE_THE_NODE),
            "overrun": Case(sketches.OVERRUNS_AN_ARRAY),
            "space": Case(sketches.NAMES_A_TOPIC_WITH_A_SPACE),
            "small": Case(sketches.HAS_A_SMALL_INPUT_BUFFER),
            "tiny": Case(sketches.HAS_A_SMALL_OUTPUT_BUFFER),
            "few": Case(sketches.WRITES_TOO_FEW_BYTES),
            "many": Case(sketches.WRITES_TOO_MANY_BYTES),
            "more": Case(sketches.SENDS_MORE_THAN_IT_ANNOUNCED),
            "stale": Case(sketches.ARM, built_with={ARM: old}, known={ARM: new}),
            "unknown": Case(sketches.ARM, built_with={ARM: new}),
        },
        tmp_path,
        {
            "text": [Code.TEXT_BETWEEN_FRAMES],
            "overrun": [Code.RAM_OVERFLOW],
            "space": [Code.NOT_BRIDGED],
            "small": [Code.BUFFER_TOO_SMALL],
            "tiny": [Code.BUFFER_TOO_SMALL, Code.MESSAGES_MISFIT],
            "few": [Code.MESSAGES_MISFIT],
            "many": [Code.MESSAGES_TOO_LONG],
            "more": [Code.MESSAGES_TOO_LONG],
            "stale": [Code.STALE_HEADERS],
            "unknown": [Code.UNKNOWN_TYPE],
        },
    )
    assert "'distance " in only_finding(found["text"]).seen
    assert "mean'" in only_finding(found["overrun"]).seen
    assert "my chatter [std_msgs/String]" in only_finding(found["space"]).seen
    assert only_finding(found["small"]).subject == "goal"
    assert "100 bytes, and the board announced a buffer of 64" in only_finding(found["more"]).seen
    assert "arm are stale" in only_finding(found["stale"]).seen
    assert "its definition lacks 'float32 torque'" in only_finding(found["stale"]).seen
    assert "no package 'my_robot'" in only_finding(found["unknown"]).seen


async def test_boards_with_faults_at_run_time(tmp_path: Path) -> None:
    found = await examine_all(
        {
            "waits": Case(sketches.WAITS_IN_ITS_LOOP, watch_s=8.0, timing_fault=Code.SLOW_LOOP),
            "hangs": Case(sketches.HANGS_AFTER_SECONDS, watch_s=10.0),
            "watchdog": Case(sketches.IS_RESET_BY_ITS_WATCHDOG, watch_s=8.0),
            "sags": Case(sketches.HEALTHY, action=drop_supply_voltage, watch_s=8.0),
            "drifts": Case(
                sketches.STOPS_ITS_CLOCK_FOR_A_LED_STRIP, watch_s=14.0, timing_fault=Code.CLOCK_DRIFT
            ),
            "stray": Case(sketches.SENDS_WHAT_IT_NEVER_ANNOUNCED, watch_s=14.0),
            "damaged": Case(sketches.HEALTHY, commands=["fault from:flip=0.004,seed=3"], watch_s=10.0),
        },
        tmp_path,
        {
            "waits": [Code.SLOW_LOOP],
            "hangs": [Code.BOARD_SILENT],
            "watchdog": [Code.RESET_LOOP],
            "sags": [Code.RESET_LOOP],
            "drifts": [Code.CLOCK_DRIFT],
            "stray": [Code.UNANNOUNCED_MESSAGES],
            "damaged": [Code.FRAMES_DAMAGED],
        },
    )
    assert "too slow" in only_finding(found["drifts"]).seen
    assert "have topic id 140," in only_finding(found["stray"]).seen
    assert " % of the frames are damaged" in only_finding(found["damaged"]).seen

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from msgspec.structs import replace

from rostether.bridge.health.board_status import BoardStatus, EndpointStatus, read_statuses
from rostether.cli.bridge.doctor_report import reported_lines
from rostether.cli.bridge.monitor_table import amount, duration, table

ARM = BoardStatus(
    name="/arm",
    state="connected",
    level=0,
    message="no problem found",
    peer="/dev/ttyACM0",
    connected_s=3723.0,
    received_bytes=3_400_000,
    received_bytes_s=1234.0,
    sent_bytes=12_000,
    sent_bytes_s=84.0,
    checksum_errors=0,
    resets=0,
    reconnects=1,
    round_trip_ms=3.14,
    clock_offset_ms=-12.5,
    clock_drift_ppm=80.0,
    endpoints=(
        EndpointStatus("subscriber", "toggle_led", "std_msgs/Empty", 3, 0.5, 0),
        EndpointStatus("service server", "reset", "std_srvs/Trigger", 1, 0.0, 0),
        EndpointStatus("publisher", "chatter", "std_msgs/String", 100, 10.0, 4),
    ),
    findings=(),
)
DAMAGE = (
    "27 % of the frames come damaged; use a shorter or shielded cable away from motors, check the ground wire"
)


def text(*boards: BoardStatus, width: int = 80, height: int | None = None) -> list[str]:
    return [line.text for line in table(boards, width, height)]


def test_one_board_at_80_columns() -> None:
    assert text(ARM) == [
        "BOARD           STATE            UP  IN/s OUT/s DROPS   BAD RECON RTT ms   CLOCK",
        "/arm            connected     1h02m  1.2k    84     4     0     1    3.1 -12.5ms",
        "   -> chatter     std_msgs/String                  10.0 Hz  4 lost",
        "   <- toggle_led  std_msgs/Empty                    0.5 Hz",
        "   => reset       std_srvs/Trigger                  1 call",
    ]


def test_totals_where_there_is_room() -> None:
    head, row, *_ = text(ARM, width=110)
    assert head.split()[-2:] == ["IN", "OUT"]
    assert row.split()[-2:] == ["3.4M", "12k"]


def test_what_does_not_fit_a_narrow_window_is_skipped_whole() -> None:
    head, row, *_ = text(ARM, width=60)
    assert head.split() == ["BOARD", "STATE", "UP", "IN/s", "OUT/s", "DROPS", "BAD"]
    assert row.split() == ["/arm", "connected", "1h02m", "1.2k", "84", "4", "0"]


def test_sorted_with_findings_in_full_below_their_board() -> None:
    bad = replace(ARM, name="/a_wheel", level=2, findings=(DAMAGE,), endpoints=())
    lines = text(ARM, bad)
    assert [line.split()[0] for line in lines if line.startswith("/")] == ["/a_wheel", "/arm"]
    assert lines[2].startswith("   ! 27 %")
    assert " ".join(part.strip() for part in lines[2:4]) == f"! {DAMAGE}"


@pytest.mark.parametrize("width", [1, 40, 60, 80, 100, 200])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    long = replace(
        ARM,
        name="/a_very/deep_namespace/with_a_board_of_a_long_name",
        connected_s=1e9,
        received_bytes_s=1e15,
        clock_offset_ms=-1e12,
        round_trip_ms=1e6,
        findings=(DAMAGE, "x" * 300),
        endpoints=(
            EndpointStatus("publisher", "t" * 200, "p/" + "T" * 200, 10**9, 1e6, 10**9),
            *ARM.endpoints,
        ),
    )
    assert max(len(line) for line in text(long, width=width)) <= max(width, 40)


def test_a_low_window_shows_what_is_wrong_first_and_counts_the_rest() -> None:
    boards = [replace(ARM, name=f"/board_{number:02}") for number in range(20)]
    boards[7] = replace(boards[7], level=1, findings=("it is on fire",))
    lines = text(*boards, height=23)
    assert len(lines) == 23
    assert "   ! it is on fire" in lines
    assert not any("chatter" in line for line in lines)
    assert lines[-1] == "topics are not shown; use a taller window or --once to show all"
    lines = text(*boards, height=22)
    assert len(lines) == 22
    assert lines[-1].startswith("problems and topics are not shown")
    lines = text(*boards, height=10)
    assert len(lines) == 10
    assert lines[-1] == "... and 12 more boards; use a taller window or --once to show all"
    assert text(*boards, height=21)[-1].startswith("... and 1 more board;")
    assert len(text(*boards, height=500)) == 1 + 20 * 4 + 1


def test_long_names_stay_distinct_and_in_order() -> None:
    boards = [replace(ARM, name=f"/tcp_192_168_0_7_{number}", endpoints=()) for number in (10, 2, 1)]
    _, *rows = text(*boards)
    assert [row.split()[0] for row in rows] == ["/tcp_..68_0_7_1", "/tcp_..68_0_7_2", "/tcp_..8_0_7_10"]


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [(None, "-"), (0.4, "0s"), (59.9, "59s"), (303, "5m03s"), (7620, "2h07m"), (273_600, "3d04h")],
)
def test_durations(seconds: float | None, shown: str) -> None:
    assert duration(seconds) == shown


@pytest.mark.parametrize(
    ("number", "shown"),
    [
        (0, "0"),
        (999, "999"),
        (999.6, "1.0k"),
        (1234, "1.2k"),
        (9_960, "10k"),
        (34_000_000, "34M"),
        (2e15, "2000T"),
    ],
)
def test_amounts(number: float, shown: str) -> None:
    assert amount(number) == shown


def status(name: str = "arm: rosserial", **values: str) -> Any:
    pairs = {"state": "connected", **values}
    return SimpleNamespace(
        name=name,
        level=1,
        message="a \x1b[2Jmessage",
        values=[SimpleNamespace(key=key, value=value) for key, value in pairs.items()],
    )


def test_statuses_of_others_are_skipped() -> None:
    other = status("hokuyo: rosserial")
    other.values = []
    array = SimpleNamespace(status=[status("camera: frequency"), other, status()])
    assert [board.name for board in read_statuses(array)] == ["/arm"]


def test_every_status_is_read() -> None:
    values = {
        "connected [s]": "12",
        "received [bytes]": "99",
        "received [bytes/s]": "many",
        "checksum errors": "3",
        "clock offset [ms]": "+0.4",
        "round trip [ms]": "unknown",
        "publisher a [messages]": "7",
        "publisher a [Hz]": "2.5",
        "publisher a type": "std_msgs/String",
        "service client b [messages]": "1",
        "gibberish [messages]": "1",
        "finding text-received": "it\nprints \x1b[31mred",
    }
    (board,) = read_statuses(SimpleNamespace(status=[status(**values)]))
    assert (board.connected_s, board.received_bytes, board.received_bytes_s) == (12.0, 99, 0.0)
    assert (board.checksum_errors, board.clock_offset_ms, board.round_trip_ms) == (3, 0.4, None)
    assert [
        (each.role, each.name, each.type, each.message_count, each.rate_hz) for each in board.endpoints
    ] == [
        ("publisher", "a", "std_msgs/String", 7, 2.5),
        ("service client", "b", "", 1, 0.0),
    ]
    assert board.findings == ("it prints \\u001b[31mred",)
    assert board.message == "a \\u001b[2Jmessage"


def test_the_doctor_counts_damaged_frames() -> None:
    for count, words in ((0, "0 damaged frames"), (1, "1 damaged frame"), (2, "2 damaged frames")):
        lines = reported_lines(replace(ARM, checksum_errors=count), "http://localhost:11311")
        assert f"  board: connected for 3723 s, /dev/ttyACM0, {words}" in lines

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from rostether.errors import RemoteProtocolError
from rostether.platform.command_frame import NO_KEY
from rostether.platform.command_link import (
    CommandReceiver,
    CommandSender,
    ReceiverSettings,
    SenderSettings,
)
from rostether.platform.host_state import read_signal_dbm
from rostether.platform.robot_table import RobotKey, RobotTable, hosts_of_duplicate_ids
from rostether.platform.status_frame import HostState, Refusal, RobotStatus, decode_status
from rostether.platform.status_reporter import StatusReporter

KEY = b"0123456789abcdef"
SETTINGS = SenderSettings(3, to_groups=False, key=KEY)
STATUS = RobotStatus(3, 1_000, 7, 6, 1, True, Refusal.HELD, -61, "192.168.1.5:40000")


class Robot:
    def __init__(self) -> None:
        self.receiver = CommandReceiver(ReceiverSettings(3, key=KEY))
        self.reporter = StatusReporter(3, KEY)

    def answer(self, datagram: bytes, address: str, now_s: float) -> RobotStatus | None:
        self.receiver.receive(datagram, now_s)
        answer = self.reporter.answer(self.receiver, address, now_s, lambda: -61)
        return None if answer is None else decode_status(answer, KEY)


@pytest.mark.parametrize(
    "status", [STATUS, replace(STATUS, host=HostState(1_700_000_000_000_000, 5), last_epoch_us=9)]
)
def test_a_status_is_whole_or_refused(status: RobotStatus) -> None:
    datagram = status.encode(KEY)
    assert decode_status(datagram, KEY) == status
    for index in range(len(datagram)):
        damaged = bytearray(datagram)
        damaged[index] ^= 1
        with pytest.raises(RemoteProtocolError):
            decode_status(bytes(damaged), KEY)
        with pytest.raises(RemoteProtocolError):
            decode_status(datagram[:index], KEY)
    with pytest.raises(RemoteProtocolError, match="a different key"):
        decode_status(datagram, NO_KEY)


def test_a_robot_answers_each_sender_once_a_second_and_names_who_commands_it() -> None:
    robot, first, second = Robot(), CommandSender(SETTINGS, 1_000), CommandSender(SETTINGS, 2_000)
    answer = robot.answer(first.command(b"go", 0.0)[0], "a:1", 0.0)
    assert answer == RobotStatus(3, 1_000, 1, 1, 0, True, Refusal.NONE, -61, "a:1", last_epoch_us=1_000)
    assert robot.answer(first.repeat(0.5)[0], "a:1", 0.5) is None
    copied = first.repeat(0.6)[0]
    answer = robot.answer(first.repeat(1.0)[0], "a:1", 1.0)
    assert answer is not None
    # Two copies of the first command were never forwarded, and one frame is still on its way.
    assert (answer.received_count, answer.lost_count) == (3, 3)
    refused = robot.answer(second.command(b"go", 1.1)[0], "b:1", 1.1)
    assert refused is not None
    assert (refused.refusal, refused.holder, refused.is_moving) == (Refusal.HELD, "a:1", True)
    # A copy from another address and damaged frames get no answer.
    assert robot.answer(copied, "thief:1", 9.0) is None
    assert robot.answer(copied[:-1], "thief:1", 9.0) is None
    observed = robot.answer(CommandSender(SETTINGS, 3_000).query(), "c:1", 9.0)
    assert observed is not None
    assert (observed.holder, observed.is_moving, observed.refusal) == ("", False, Refusal.NONE)
    robot.receiver.receive(CommandSender(SETTINGS, 4_000).stop(9.0)[0], 9.0)
    older = robot.answer(second.command(b"go", 9.1)[0], "b:1", 9.1)
    assert older is not None
    assert (older.refusal, older.last_epoch_us) == (Refusal.OLDER, 4_000)


def test_the_memory_for_senders_is_bounded() -> None:
    robot = Robot()
    for epoch_us in range(1_000, 1_100):
        assert robot.answer(CommandSender(SETTINGS, epoch_us).query(), "a:1", 0.0) is not None
    assert len(robot.reporter._senders) == 8


def test_a_robot_that_loses_more_than_a_tenth_gets_unicast_while_it_answers() -> None:
    table = RobotTable(KEY)

    def receive(received: int, lost: int, sequence: int, now_s: float) -> bool:
        status = replace(STATUS, received_count=received, lost_count=lost, sequence=sequence)
        return table.receive(status.encode(KEY), ("10.0.0.3", 5), 1_000, now_s) is not None

    assert receive(1, 0, 1, 0.0)
    assert table.unicast_addresses(0.0) == []
    assert receive(19, 2, 21, 1.0)
    assert table.unicast_addresses(1.0) == []
    assert receive(30, 5, 35, 2.0)
    assert table.unicast_addresses(2.0) == [("10.0.0.3", 5)]
    # The loss now includes both directions.
    assert receive(60, 5, 65, 3.0)
    assert table.unicast_addresses(3.0) == [("10.0.0.3", 5)]
    assert table.unicast_addresses(13.1) == []
    assert hosts_of_duplicate_ids(table.robots) == {}
    assert table.receive(STATUS.encode(KEY), ("10.0.0.4", 5), 1_000, 3.0) is not None
    assert hosts_of_duplicate_ids(table.robots) == {3: ["10.0.0.3", "10.0.0.4"]}


def test_old_foreign_and_forged_statuses_are_ignored() -> None:
    table = RobotTable(KEY)
    place = ("10.0.0.3", 5)
    assert table.receive(STATUS.encode(KEY), place, 1_000, 0.0) is not None
    assert table.receive(STATUS.encode(KEY), place, 1_000, 0.0) is None
    assert table.receive(replace(STATUS, sequence=8).encode(), place, 1_000, 0.0) is None
    assert table.receive(replace(STATUS, sequence=8).encode(KEY), place, 2_000, 0.0) is None
    assert table.robots[RobotKey(3, "10.0.0.3")].status == STATUS


def test_the_signal_of_wireless_interfaces(tmp_path: Path) -> None:
    path = tmp_path / "wireless"
    assert read_signal_dbm(path=path) is None
    path.write_text(
        "Inter-| sta-|   Quality        |   Discarded packets               | Missed | WE\n"
        " face | tus | link level noise |  nwid  crypt   frag  retry   misc | beacon | 22\n"
        " wlan0: 0000   54.  -56.  -256        0      0      0      0      0        0\n"
        " wlan1: 0000   54.  200.  -256        0      0      0      0      0        0\n"
    )
    assert read_signal_dbm(path=path) == -56
    assert read_signal_dbm(("wlan1",), path) == -56
    assert read_signal_dbm(("eth0",), path) is None

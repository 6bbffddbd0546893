from __future__ import annotations

import pytest

from rostether.gateways.teleop.command_lease import HOLD_S, KEEP_S, CommandLease


@pytest.fixture
def lease() -> CommandLease[str]:
    return CommandLease[str]()


def test_nothing_is_due_before_the_first_command(lease: CommandLease[str]) -> None:
    assert lease.due_s is None
    assert not lease.expire(100.0)


def test_a_command_that_is_not_repeated_becomes_one_stop(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    assert lease.due_s == 10.0 + KEEP_S
    assert not lease.expire(10.0 + KEEP_S - 0.001)
    assert lease.expire(10.0 + KEEP_S)
    assert not lease.expire(10.0 + KEEP_S + 0.1)
    assert lease.driver == "anna"


def test_a_command_that_is_repeated_continues(lease: CommandLease[str]) -> None:
    for step in range(20):
        lease.command("anna", step * 0.05, is_stop=False)
        assert not lease.expire(step * 0.05 + 0.04)


def test_a_driver_that_stopped_by_itself_gets_no_second_stop(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    lease.command("anna", 10.05, is_stop=True)
    assert not lease.expire(10.05 + KEEP_S)
    assert not lease.release("anna")


def test_one_drives_at_a_time_until_the_first_was_silent(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    assert not lease.admits("ben", 10.05, is_stop=False)
    assert lease.expire(10.0 + KEEP_S)
    assert not lease.admits("ben", 10.5, is_stop=False)
    assert lease.due_s == 10.0 + HOLD_S
    lease.expire(10.0 + HOLD_S)
    assert lease.driver is None
    assert lease.admits("ben", 11.1, is_stop=False)
    lease.command("ben", 11.1, is_stop=False)
    assert not lease.admits("anna", 11.2, is_stop=False)


def test_a_stop_of_another_client_holds(lease: CommandLease[str]) -> None:
    lease.command("a", 0.0, is_stop=False)
    assert lease.admits("b", 0.01, is_stop=True)
    lease.command("b", 0.01, is_stop=True)
    assert lease.driver == "b"
    assert not lease.admits("a", 0.02, is_stop=False)
    assert not lease.expire(0.2)


def test_a_driver_that_leaves_stops_the_robot_and_frees_it(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    assert not lease.release("ben")
    assert lease.release("anna")
    assert not lease.release("anna")
    assert lease.due_s is None
    assert lease.admits("ben", 10.01, is_stop=False)


def test_a_late_look_does_both(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    assert lease.expire(20.0)
    assert lease.driver is None


def test_a_driver_that_was_silent_while_it_moved_must_stop_first(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    assert lease.admits("anna", 10.0 + HOLD_S - 0.01, is_stop=False)
    # Its commands of the time when the network stalled arrive at once.
    assert not lease.admits("anna", 10.0 + HOLD_S, is_stop=False)
    lease.expire(10.0 + HOLD_S)
    assert not lease.admits("anna", 20.0, is_stop=False)
    assert lease.admits("ben", 20.0, is_stop=False)
    lease.command("anna", 20.0, is_stop=True)
    assert lease.admits("anna", 20.0, is_stop=False)


def test_a_driver_that_stopped_may_be_silent(lease: CommandLease[str]) -> None:
    lease.command("anna", 10.0, is_stop=False)
    lease.command("anna", 10.05, is_stop=True)
    lease.expire(20.0)
    assert lease.admits("anna", 20.0, is_stop=False)

from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.platform.command_frame import Flags, decode_frame
from rostether.platform.command_link import SenderSettings
from rostether.platform.fleet import FleetSender, FleetSettings, silence_text
from rostether.platform.multicast_socket import GroupAddress
from unit.platform.datagrams import PlainReceiver, loopback_group
from unit.platform.typed_nodes import Lines
from waiting import until

ONE_ROBOT = SenderSettings(7, to_groups=False)


async def test_queries_change_nothing_and_a_drive_ends_with_a_halt_and_a_release() -> None:
    address, lines = loopback_group(), Lines()
    receiver = PlainReceiver(address)

    def flags() -> list[Flags]:
        return [decode_frame(each).flags for each in receiver.datagrams]

    observer = FleetSender(FleetSettings(ONE_ROBOT, address), lines)
    await observer.query(0.06)
    observer.close()
    await until(lambda: receiver.datagrams)
    assert set(flags()) == {Flags.QUERY}
    receiver.datagrams.clear()
    sender = FleetSender(FleetSettings(ONE_ROBOT, address), lines)
    await sender.drive(b"go", 0.1)
    sender.close()
    await until(lambda: flags().count(Flags.RELEASE) == 3)
    assert lines.texts == [silence_text(FleetSettings(ONE_ROBOT, address))]
    assert flags().count(Flags(0)) == 10
    assert set(flags()) == {Flags.ARMED, Flags(0), Flags.RELEASE}
    receiver.datagrams.clear()
    stopper = FleetSender(FleetSettings(ONE_ROBOT, address), lines)
    assert await stopper.stop() == []
    stopper.close()
    receiver.close()
    # The robot does not confirm the stop: there are three rounds.
    assert flags().count(Flags.STOP) == 30
    assert silence_text(FleetSettings(ONE_ROBOT, address)).startswith(
        f"robot 7 does not answer at {address}; check the key"
    )


def test_addresses_that_are_wrong() -> None:
    with pytest.raises(ConfigError, match="'robots' is not a numeric IP address"):
        FleetSender(FleetSettings(address=GroupAddress("robots")), Lines())
    with pytest.raises(ConfigError, match="at most 100 unicast addresses"):
        FleetSender(FleetSettings(unicast=("10.0.0.1",) * 101), Lines())

"""`rostether xbee` and the nodes of rosserial_xbee. The page "Connect boards by XBee" runs them."""

from __future__ import annotations

import pytest

from rostether.cli.bridge.rosserial_hosts import network_link
from rostether.errors import ConfigError
from unit.cli.command_shell import Shell


def test_the_link_of_a_network() -> None:
    link = network_link(["/dev/ttyUSB0", "1", "2"], {}, "name=xbee_network&ns=/lab")
    assert link == "xbee:/dev/ttyUSB0?peers=1,2&name=xbee_network&ns=/lab"
    with pytest.raises(ConfigError, match="the address of each board, for example /dev/ttyUSB0 1 2"):
        network_link(["/dev/ttyUSB0"], {}, "name=xbee_network")


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("setup", "/dev/x"), "give the board's ADDRESS, for instance 1, or --coordinator"),
        (("setup", "/dev/x", "0xffff"), "write from 0 to 0xfffd"),
        (("setup", "/dev/x", "1", "-c", "0A"), "'0A' is not a hexadecimal number from B to 1A"),
        (("setup", "/dev/x", "--to", "1"), "write the 16 hexadecimal digits on a radio's label"),
        (("setup", "/dev/x", "-C", "--to", "0013A20040A1B2C3"), "--to is for the radios of boards"),
        (
            ("setup", "tcp:localhost:4000", "1"),
            "tcp:localhost:4000 is not a serial port; connect the radio to",
        ),
        (("simulate",), "give --link, the serial port for `rostether serve`, or --fresh"),
        (("simulate", "x.ino", "--fresh", "y"), "SKETCH is for the boards of a network; give --link"),
    ],
)
def test_wrong_arguments(shell: Shell, arguments: tuple[str, ...], text: str) -> None:
    assert text in shell.failure("xbee", *arguments, code=2)

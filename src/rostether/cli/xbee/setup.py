"""`rostether xbee setup`: sets up one radio; also typed as `rosrun rosserial_xbee setup_xbee.py`."""

from __future__ import annotations

import re

import click

from rostether.cli.shell.option_group import add_flag, add_option
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.transports.address import DEFAULT_BAUD, SerialAddress
from rostether.transports.address_advice import check_typed_port
from rostether.transports.opening import list_serial_ports, open_transport
from rostether.transports.xbee.radio_address import is_long, parse_radio_address, show_radio_address
from rostether.transports.xbee.set_up import BAUD_CODES, RadioSettings, set_up_radio

# The start of an address such as tcp:localhost:4000.
_LINK_ADDRESS = re.compile(r"[a-z]+:")
# A PAN id has 16 bits.
_MAX_PAN_ID = 0xFFFF
# The lowest and the highest channel of IEEE 802.15.4 at 2.4 GHz.
_CHANNELS = (0x0B, 0x1A)


class _Hexadecimal(click.ParamType[int]):
    """A number as XCTU shows it, with or without 0x."""

    name = "HEX"

    def __init__(self, lowest: int, highest: int) -> None:
        self._lowest, self._highest = lowest, highest

    def convert(self, value: str | int, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number, or fail."""
        try:
            number = value if isinstance(value, int) else int(value, 16)
        except ValueError:
            number = -1
        if not self._lowest <= number <= self._highest:
            self.fail(f"{value!r} is not a hexadecimal number from {self._lowest:X} to {self._highest:X}")
        return number


class _RadioAddress(click.ParamType[int]):
    """An address of 16 bits, or with `is_long` one of 64."""

    def __init__(self, *, is_long: bool) -> None:
        self.name = "LABEL" if is_long else "ADDRESS"
        self._is_long = is_long

    def convert(self, value: str | int, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the address, or fail."""
        address = value if isinstance(value, int) else parse_radio_address(value)
        if address is None or is_long(address) != self._is_long:
            what = "the 16 hexadecimal digits on a radio's label" if self._is_long else "from 0 to 0xfffd"
            self.fail(f"{value!r} is not an address; write {what}")
        return address


@verb(
    "setup",
    """
    rostether xbee setup --coordinator /dev/ttyUSB0      the radio at the computer
    rostether xbee setup /dev/ttyUSB1 1                  the radio of board 1
    rostether xbee setup /dev/ttyUSB1 1 --pan-id 1332 --channel 0F
    rostether xbee setup /dev/ttyUSB1 --to 0013A20040A1B2C3
    """,
)
@add_flag("-C --coordinator", "Set up the radio at the computer.")
@add_option(
    "-P --pan-id",
    "The network's number, hexadecimal; the same in all radios.",
    type=_Hexadecimal(0, _MAX_PAN_ID),
    default="1331",
    show_default=True,
)
@add_option(
    "-c --channel",
    "The channel, hexadecimal; the same in all radios.",
    type=_Hexadecimal(*_CHANNELS),
    default="0D",
    show_default=True,
)
@add_option(
    "--to coordinator_address",
    "The 64-bit address of the radio at the computer, to which this one sends.",
    type=_RadioAddress(is_long=True),
)
@add_option(
    "--baud",
    "The speed of the radio's serial port.",
    type=click.Choice([str(baud) for baud in BAUD_CODES]),
    default=str(DEFAULT_BAUD),
    show_default=True,
)
@click.argument("port")
@click.argument("address", type=_RadioAddress(is_long=False), required=False)
@json_option
async def xbee_setup(
    port: str,
    address: int | None,
    coordinator: bool,
    pan_id: int,
    channel: int,
    coordinator_address: int | None,
    baud: str,
    as_json: bool,
) -> None:
    """Set up the XBee radio on PORT, and write the settings to its flash.

    ADDRESS is the radio's own 16-bit address, from 1 for boards. A board's radio without one, and every
    DigiMesh radio, needs --to instead. All other settings get their factory values. The radio is found at any
    usual baud rate, even in API mode.
    """
    if coordinator and coordinator_address is not None:
        raise click.UsageError("--to is for the radios of boards; give --to or --coordinator, not both")
    if not coordinator and address is None and coordinator_address is None:
        raise click.UsageError("give the board's ADDRESS, for instance 1, or --coordinator")
    if _LINK_ADDRESS.match(port):
        raise click.UsageError(f"{port} is not a serial port; connect the radio to one, such as /dev/ttyUSB0")
    check_typed_port(SerialAddress(port), list_serial_ports)
    own_address = 0 if coordinator and address is None else address
    settings = RadioSettings(own_address, coordinator, coordinator_address or 0, pan_id, channel, int(baud))
    found, commands = await set_up_radio(
        lambda baud: open_transport(SerialAddress(port, baud)), settings, warn
    )
    if as_json:
        write_json(
            {
                "port": port,
                "baud": settings.baud,
                "kind": found.kind,
                "hardware": f"{found.hardware:04X}",
                "firmware": f"{found.firmware:04X}",
                "radio_address": show_radio_address(found.serial_number),
                "commands": commands,
            }
        )
        return
    write_line(f"Found {found.kind}, firmware {found.firmware:04X}, at {found.baud} baud")
    write_line(f"Set {' '.join(commands)}")
    write_line(f"Its 64-bit address is {show_radio_address(found.serial_number)}")
    if settings.is_coordinator:
        speed = "" if settings.baud == DEFAULT_BAUD else f"?baud={settings.baud}"
        write_line(f'Ready for: rostether serve "xbee:{port}{speed}"')

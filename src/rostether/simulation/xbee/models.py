"""The registers of XBee radios: their factory values, and the largest values.

Source: Digi, XBee/XBee-PRO S1 802.15.4 (Legacy) User Guide; XBee 3 802.15.4 and DigiMesh User Guides, "AT
commands".
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from msgspec import Struct

BAUD_RATES = (1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200)

# Name: factory setting, largest value. Read-only registers have no largest value.
_COMMON: dict[str, tuple[int, int | None]] = {
    "AP": (0, 2),
    "BD": (3, len(BAUD_RATES) - 1),
    "CH": (0x0C, 0x1A),
    "CT": (0x64, 0xFFFF),
    "DB": (0, None),
    "DH": (0, 0xFFFFFFFF),
    "GT": (0x3E8, 0xCE4),
    "HV": (0, None),
    # The radio's name, a blank; programs that manage radios read it.
    "NI": (0x20, None),
    "RO": (3, 0xFF),
    "SH": (0, None),
    "SL": (0, None),
    "VR": (0, None),
}
_SHORT_ADDRESSES: dict[str, tuple[int, int | None]] = {
    "CE": (0, 1),
    "DL": (0, 0xFFFFFFFF),
    "ID": (0x3332, 0xFFFF),
    "MM": (0, 3),
    "MY": (0, 0xFFFF),
    "RN": (0, 3),
    "RR": (0, 6),
}


class Model(Struct, frozen=True):
    """A kind of radio: its registers, the largest payload of a packet, and whether it forms a mesh."""

    name: str
    hardware: int
    firmware: int
    registers: Mapping[str, tuple[int, int | None]]
    packet_bytes: int
    is_mesh: bool = False


SERIES_1 = Model("series1", 0x1747, 0x10EC, MappingProxyType({**_COMMON, **_SHORT_ADDRESSES}), 100)
SERIES_3 = Model(
    "series3", 0x4102, 0x2014, MappingProxyType({**_COMMON, **_SHORT_ADDRESSES, "NP": (0x74, None)}), 116
)
DIGIMESH = Model(
    "digimesh",
    0x4102,
    0x300D,
    MappingProxyType(
        {
            **_COMMON,
            "CE": (0, 2),
            # The broadcast address.
            "DL": (0xFFFF, 0xFFFFFFFF),
            "ID": (0x7FFF, 0xFFFF),
            "MR": (1, 7),
            "NH": (7, 0x20),
            "NP": (0x49, None),
            "RR": (0x0A, 0x0F),
        }
    ),
    73,
    is_mesh=True,
)

MODELS = {model.name: model for model in (SERIES_1, SERIES_3, DIGIMESH)}

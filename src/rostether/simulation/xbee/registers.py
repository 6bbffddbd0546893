"""The registers of XBee radios: names, factory values and limits for each model, and the values of one radio.

Source: Digi, XBee/XBee-PRO S1 802.15.4 (Legacy) User Guide; XBee 3 802.15.4 and DigiMesh User Guides, "AT
commands".
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from msgspec import Struct

_HALF_BITS = 32
_NO_VALUE: tuple[bool, None] = (True, None)

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


class Registers:
    """Reads and sets registers with AT commands; `[]` returns the value in use."""

    def __init__(self, model: Model, serial_number: int) -> None:
        self.signal_dbm = 0
        self._model = model
        self._fixed = {
            "HV": model.hardware,
            "VR": model.firmware,
            "SH": serial_number >> _HALF_BITS,
            "SL": serial_number & 0xFFFFFFFF,
        }
        self._stored = self._factory()
        self._set = dict(self._stored)
        self._used = dict(self._stored)

    def __getitem__(self, name: str) -> int:
        return self._used[name]

    def execute(self, command: str, value: int | None) -> tuple[bool, int | None]:
        """Run an AT command; return whether it is valid, and the value that it reads."""
        match command:
            case "WR":
                self._stored = dict(self._set)
            case "RE":
                self._set = self._factory()
            case "AC" | "CN":
                self.apply()
            case "FR":
                self._set = dict(self._stored)
                self.apply()
            case _:
                return self._access(command, value)
        return _NO_VALUE

    def apply(self) -> None:
        """Use the values that were set since the last call."""
        self._used = dict(self._set)

    def as_bytes(self, command: str, value: int | None) -> bytes:
        """Return a value as in frames, in as many bytes as the register's largest value needs."""
        if value is None:
            return b""
        largest = self._model.registers.get(command, (0, None))[1] or value
        return value.to_bytes(max(1, (largest.bit_length() + 7) // 8), "big")

    def _access(self, command: str, value: int | None) -> tuple[bool, int | None]:
        if command not in self._model.registers:
            return False, None
        if value is None:
            return True, -self.signal_dbm if command == "DB" else self._set[command]
        largest = self._model.registers[command][1]
        if largest is None or value > largest:
            return False, None
        self._set[command] = value
        return _NO_VALUE

    def _factory(self) -> dict[str, int]:
        return {name: default for name, (default, _) in self._model.registers.items()} | self._fixed

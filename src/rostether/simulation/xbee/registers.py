"""The registers of a simulated radio: values in use, values not applied yet, and values in its flash."""

from __future__ import annotations

from rostether.simulation.xbee.models import Model

_HALF_BITS = 32
_NO_VALUE: tuple[bool, None] = (True, None)


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

"""The pins of the board OpenCR by the names of its Arduino core."""

from __future__ import annotations

from rostether.errors import ConfigError

PIN_COUNT = 85
NAMES = {
    **{f"A{number}": 16 + number for number in range(6)},
    **{f"BDPIN_LED_USER_{number}": 21 + number for number in range(1, 5)},
    "BDPIN_DIP_SW_1": 26,
    "BDPIN_DIP_SW_2": 27,
    "BDPIN_SPI_CS_IMU": 28,
    "BDPIN_BAT_PWR_ADC": 29,
    "BDPIN_BUZZER": 31,
    "BDPIN_DXL_PWR_EN": 32,
    "BDPIN_PUSH_SW_1": 34,
    "BDPIN_PUSH_SW_2": 35,
    "BDPIN_LED_STATUS": 36,
    # The connectors for OLLO sensors.
    "OLLO_2": 45,
    "OLLO_3": 72,
    "OLLO_4": 75,
    **{f"BDPIN_GPIO_{number}": 49 + number for number in range(1, 19)},
}
_BY_NUMBER = {number: name for name, number in NAMES.items()}


def pin_number(name: str) -> int:
    """Return the number of a pin. `name`: BDPIN_PUSH_SW_1, PUSH_SW_1, A1, D13 or 13. Raises ConfigError."""
    upper = name.upper()
    for each in (upper, f"BDPIN_{upper}"):
        if each in NAMES:
            return NAMES[each]
    digits = upper.removeprefix("D")
    if digits.isascii() and digits.isdigit() and len(digits) < 3 and int(digits) < PIN_COUNT:
        return int(digits)
    raise ConfigError(
        f"the OpenCR has no pin {name!r}; its pins have names such as BDPIN_PUSH_SW_1, A1 and D13"
    )


def pin_name(number: int) -> str:
    """Return the name of a pin."""
    return _BY_NUMBER.get(number, f"D{number}")

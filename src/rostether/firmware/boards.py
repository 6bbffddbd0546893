"""The boards in an Arduino core's boards.txt, by the names that users type."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches

from rostether.errors import ConfigError
from rostether.firmware.properties import expand, parse_properties

# Common names of boards that have other names in boards.txt.
_ALIASES = {
    "mega2560": "mega",
    "mega1280": "mega:atmega1280",
    "atmega2560": "mega",
    "atmega328": "uno",
    "atmega328p": "uno",
    "atmega32u4": "leonardo",
    "unor3": "uno",
    "nanoold": "nano:atmega328old",
    "nano168": "nano:atmega168",
    "promini": "pro:16MHzatmega328",
    "promini16": "pro:16MHzatmega328",
    "promini8": "pro:8MHzatmega328",
    "duemilanove": "diecimila:atmega328",
    "promicro": "micro",
}

# Boards of other platforms, by the names that users type without the platform.
_OTHER_PLATFORMS = {
    "opencr": "OpenCR:OpenCR:OpenCR",
    "unor4wifi": "arduino:renesas_uno:unor4wifi",
    "unor4minima": "arduino:renesas_uno:minima",
    "due": "arduino:sam:arduino_due_x",
    "esp32": "esp32:esp32:esp32",
    "esp8266": "esp8266:esp8266:generic",
    "nodemcu": "esp8266:esp8266:nodemcuv2",
    "pico": "rp2040:rp2040:rpipico",
    "picow": "rp2040:rp2040:rpipicow",
    "zero": "arduino:samd:arduino_zero_native",
    "teensy40": "teensy:avr:teensy40",
    "teensy41": "teensy:avr:teensy41",
}

# The boards that an error lists: the most common ones, because all 26 do not fit in a line.
_SHOWN = ("uno", "mega", "leonardo", "nano", "micro", "promini", "mini", "ethernet")

_PLATFORM = ("arduino", "avr")


@dataclass(frozen=True, slots=True)
class Board:
    """One board with one of its processors.

    `flash_bytes` is the flash without the bootloader. Both sizes are 0 if only arduino-cli knows them.
    `needs_touch`: opening its port at 1200 baud starts the bootloader. `usb_ids` are pairs of vendor and
    product. `properties` are those of boards.txt without the board's prefix.
    """

    name: str
    title: str
    fqbn: str
    mcu: str = ""
    flash_bytes: int = 0
    ram_bytes: int = 0
    upload_protocol: str = ""
    upload_speed_baud: int = 0
    needs_touch: bool = False
    usb_ids: tuple[tuple[int, int], ...] = ()
    properties: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    @property
    def is_avr(self) -> bool:
        """Whether it is a board of the AVR core, for which avr-gcc builds."""
        return bool(self.mcu)


class BoardTable:
    """The boards of one boards.txt."""

    def __init__(self, boards_txt: str) -> None:
        self._properties = parse_properties(boards_txt)
        self.names = [key[: -len(".name")] for key in self._properties if re.fullmatch(r"\w+\.name", key)]
        self._by_plain_name = {_plain(name): name for name in self.names}

    def find(self, name: str) -> Board:
        """Return a board by name (`uno`), with its processor (`nano:atmega328old`) or by FQBN.

        Raises ConfigError, which lists known boards or processors.
        """
        board, _, processor = name.removeprefix(":".join(_PLATFORM) + ":").partition(":")
        alias = _ALIASES.get(_plain(board), board)
        board_id, _, alias_processor = alias.partition(":")
        found = self._by_plain_name.get(_plain(board_id))
        if found is None:
            raise ConfigError(self._unknown(name, board))
        return self._read(found, name, processor.removeprefix("cpu=") or alias_processor)

    def _read(self, board_id: str, name: str, processor: str) -> Board:
        prefix = f"{board_id}."
        own = {
            key.removeprefix(prefix): value
            for key, value in self._properties.items()
            if key.startswith(prefix)
        }
        processors = list(
            dict.fromkeys(key.split(".")[2] for key in own if re.fullmatch(r"menu\.cpu\.\w+", key))
        )
        if processor and processor not in processors:
            known = f"it has {', '.join(processors)}" if processors else "it has only one"
            raise ConfigError(f"board {board_id} has no processor {processor!r}; {known}")
        if processors:
            chosen = f"menu.cpu.{processor or processors[0]}."
            own |= {key.removeprefix(chosen): value for key, value in own.items() if key.startswith(chosen)}
        suffix = f":cpu={processor or processors[0]}" if processors else ""
        return Board(
            name=name,
            title=own["name"],
            fqbn=":".join((*_PLATFORM, board_id)) + suffix,
            mcu=own.get("build.mcu", ""),
            flash_bytes=int(own.get("upload.maximum_size", "0")),
            ram_bytes=int(own.get("upload.maximum_data_size", "0")),
            upload_protocol=own.get("upload.protocol", ""),
            upload_speed_baud=int(own.get("upload.speed", "0")),
            needs_touch=own.get("upload.use_1200bps_touch") == "true",
            usb_ids=_usb_ids(own),
            properties={key: expand(value, own) for key, value in own.items() if "menu." not in key},
        )

    def _unknown(self, name: str, board: str) -> str:
        candidates = {_plain(each): each for each in [*self.names, *_ALIASES, *_OTHER_PLATFORMS]}
        near = [candidates[each] for each in get_close_matches(_plain(board), candidates, n=3)]
        shown = [each for each in _SHOWN if each in self.names or each in _ALIASES]
        if near:
            return f"no board {name!r}; did you mean {' or '.join(near)}?"
        return (
            f"no board {name!r}; known: {', '.join([*shown, *_OTHER_PLATFORMS])}, those of boards.txt, and "
            "with arduino-cli every FQBN, such as esp8266:esp8266:d1_mini"
        )


def other_platform_fqbn(name: str) -> str | None:
    """Return the FQBN of a board that only arduino-cli builds for, by FQBN (`esp32:esp32:esp32`) or by name.

    None for Arduino's AVR boards and unknown names.
    """
    parts = name.split(":")
    if len(parts) >= 3 and tuple(parts[:2]) != _PLATFORM:
        return name
    return _OTHER_PLATFORMS.get(_plain(name))


def _plain(name: str) -> str:
    return re.sub(r"[\s_\-]", "", name).lower().removeprefix("arduino")


def _usb_ids(own: Mapping[str, str]) -> tuple[tuple[int, int], ...]:
    ids = []
    for key, value in own.items():
        match = re.fullmatch(r"(?:upload_port\.|)vid\.(\d+)|upload_port\.(\d+)\.vid", key)
        if match is None:
            continue
        product = own.get(key.replace("vid", "pid"))
        if product is not None:
            ids.append((int(value, 16), int(product, 16)))
    return tuple(dict.fromkeys(ids))

from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.transports.address import SimAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.opening import open_transport


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("sim:blink.ino", SimAddress("blink.ino")),
        ("sim:/tmp/x.elf?board=mega", SimAddress("/tmp/x.elf", "mega")),
        ("SIM:x.elf?uart=2&seed=7", SimAddress("x.elf", uart=2, seed=7)),
        ("sim:x?baud=250000", SimAddress("x")),
        ("sim:x?name=arm&ns=lab", SimAddress("x", name="arm", ns="lab")),
        ("sim:x?adc=A0:2.5,A1:1", SimAddress("x", commands=("adc A0=2.5 A1=1",))),
        ("sim:x?range=0.5&watch=D13,D9", SimAddress("x", commands=("range 0.5", "watch D13 D9"))),
        ("sim:x?attitude=10,-20,30.5", SimAddress("x", commands=("attitude 10 -20 30.5",))),
        ("sim:x?hcsr04=trig:D8,echo:D7", SimAddress("x", commands=("hcsr04 trig=D8,echo=D7",))),
        ("sim:x?fault=to:flip:0.01,seed:3", SimAddress("x", commands=("fault to:flip=0.01,seed=3",))),
        ("sim:x?fault=none&autoreset=on", SimAddress("x", commands=("fault none", "autoreset on"))),
        ("sim:x?network=localhost:11411", SimAddress("x", commands=("network localhost:11411",))),
        ("sim:x?servo=D9&pin=D7:0,D8:z", SimAddress("x", commands=("servo D9", "pin D7=0 D8=z"))),
    ],
)
def test_read_as_typed(text: str, address: SimAddress) -> None:
    assert parse_address(text) == address


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("sim:", "has no path"),
        ("sim:x?baud=fast", "write a number"),
        ("sim:x?uart=4", "from 0 to 3"),
        ("sim:x?seed=-1", "from 0 to"),
        ("sim:x?adc=", "has no value"),
    ],
)
def test_what_is_wrong_is_reported(text: str, reported: str) -> None:
    with pytest.raises(ConfigError, match=reported):
        parse_address(text)


def test_one_address_is_one_board() -> None:
    address = parse_address("sim:x.elf?board=mega")
    assert str(address) == "sim:x.elf"
    assert not address.listens


async def test_it_is_not_a_link_that_could_be_opened() -> None:
    with pytest.raises(ConfigError, match=r"`rostether serve 'sim:my x.elf'` starts it"):
        await open_transport("sim:my x.elf")

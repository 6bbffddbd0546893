from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.simulation.opencr.pins import NAMES, pin_name, pin_number


def test_pins_have_the_names_of_the_board() -> None:
    assert pin_number("BDPIN_LED_USER_1") == pin_number("led_user_1") == 22
    assert pin_number("BDPIN_GPIO_18") == 67
    assert (pin_number("A1"), pin_number("D13"), pin_number("13")) == (17, 13, 13)
    assert [pin_number(pin_name(number)) for number in range(85)] == list(range(85))
    assert len(set(NAMES.values())) == len(NAMES)


@pytest.mark.parametrize("name", ["", "D85", "BDPIN_LED_USER_5", "A6", "-1", "1e1", "²"])
def test_other_names_are_refused(name: str) -> None:
    with pytest.raises(ConfigError, match=r"no pin '.*'; its pins have names such as"):
        pin_number(name)

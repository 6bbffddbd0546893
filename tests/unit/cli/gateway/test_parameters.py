from __future__ import annotations

import pytest

from rostether.cli.gateway.parameters import certificate_files, flag, whole_number
from rostether.errors import ConfigError


@pytest.mark.parametrize(
    ("value", "is_set"),
    [(True, True), ("True", True), (" yes ", True), (1, True), (False, False), ("no", False), (None, False)],
)
def test_what_is_true(value: object, is_set: bool) -> None:
    assert flag({"on": value}, "on") is is_set
    assert not flag({}, "on")


@pytest.mark.parametrize(("value", "number"), [(7, 7), (" 7 ", 7), (0, 0), (None, 5), ("", 5), ("None", 5)])
def test_whole_numbers_and_what_is_left_open(value: object, number: int) -> None:
    assert whole_number({"size": value}, "size", 5) == number
    assert whole_number({}, "size", 5) == 5


@pytest.mark.parametrize("value", ["many", -1, 1.5, True, [], "1e3"])
def test_what_is_no_whole_number_is_named(value: object) -> None:
    with pytest.raises(ConfigError, match="~size must be a whole number, not "):
        whole_number({"size": value}, "size", 5)


def test_a_certificate_is_needed_for_encryption() -> None:
    assert certificate_files({"certfile": "a.pem", "keyfile": None}, "tls") == ("a.pem", "")
    assert certificate_files({"certfile": "a.pem", "keyfile": "b.pem"}, "tls") == ("a.pem", "b.pem")
    with pytest.raises(ConfigError, match="~tls needs ~certfile and ~keyfile"):
        certificate_files({"keyfile": "b.pem"}, "tls")

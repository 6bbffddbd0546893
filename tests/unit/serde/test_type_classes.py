from __future__ import annotations

import pytest

from rostether.errors import UnknownTypeError
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.type_classes import Service, name_of_type
from rostether.serde.values import Message


class SetBool(Service[Message, Message]):
    _type = "std_srvs/SetBool"


def test_a_type_is_given_by_name_or_class() -> None:
    message_class = TypeStore(Registry()).codec("std_msgs/Bool").message_class
    given = ("std_msgs/Bool", message_class, SetBool)
    assert list(map(name_of_type, given)) == ["std_msgs/Bool", "std_msgs/Bool", "std_srvs/SetBool"]


def test_a_value_that_is_no_type_is_refused() -> None:
    with pytest.raises(UnknownTypeError, match="42 is not a type; write its name"):
        name_of_type(42)

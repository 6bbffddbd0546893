"""Types given as classes instead of names: those of `rostether.msg` and `rostether.srv`."""

from __future__ import annotations

from typing import ClassVar, Generic, TypeVar

from rostether.errors import UnknownTypeError
from rostether.serde.values import Message

Request = TypeVar("Request", bound=Message)
Response = TypeVar("Response", bound=Message)


class Service(Generic[Request, Response]):
    """A service type, with the classes of its two messages for type checkers. It has no instances."""

    # The type as `package/Name`.
    _type: ClassVar[str] = ""


def name_of_type(given: object) -> str:
    """Return the name of a type that is given by name, as a message class or as a service class.

    Raises UnknownTypeError for any other value.
    """
    if isinstance(given, str):
        return given
    name: str = getattr(given, "_type", "")
    if not name:
        raise UnknownTypeError(f"{given!r} is not a type; write its name, such as std_msgs/String")
    return name

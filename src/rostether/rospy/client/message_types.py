"""Message and service classes of all definitions that this process can find, created on demand."""

from __future__ import annotations

import keyword
import os
import threading
from functools import cached_property
from typing import Any

from rostether.errors import DefinitionError
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.parse_srv import service_of
from rostether.msgdef.registry import Registry
from rostether.rospy.client.message import AnyMsg, Message
from rostether.rospy.client.stamps import Duration, Time, new_stamp
from rostether.rospy.environment import package_search_path
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import Node, Stamp, Struct
from rostether.serde.values import Message as SerdeMessage
from rostether.serde.values import MessageClasses


class ServiceClass:
    """The base of service classes such as `std_srvs.srv.SetBool`."""

    _type: str
    _md5sum: str
    _request_class: type[Message]
    _response_class: type[Message]


class FacadeClasses(MessageClasses):
    """Creates the classes of rospy for a type store."""

    time = Time
    duration = Duration
    new_stamp = staticmethod(new_stamp)
    numbers = tuple
    text_errors = "replace"
    are_shared = False

    def __init__(self, types: MessageTypes) -> None:
        super().__init__()
        self._types = types

    def _zero(self, node: Node) -> Any:
        if isinstance(node, Stamp):
            # Stamps are mutable, so each message gets its own.
            return self.time if node.name == "time" else self.duration
        return super()._zero(node)

    def _make(self, tree: Struct) -> type[SerdeMessage]:
        made = super()._make(tree)
        namespace: dict[str, Any] = {
            key: value
            for key, value in vars(made).items()
            if key not in (*made.__slots__, "__dict__", "__doc__", "__weakref__")
        }
        description = self._types.registry.message_type(tree.name)
        first = tree.members[0] if tree.members else None
        namespace |= {
            _python_name(name): value for name, value in namespace.items() if keyword.iskeyword(name)
        }
        namespace |= {
            "__slots__": [member.name for member in tree.members],
            "_zeros": tuple((_python_name(name), zero) for name, zero in made._zeros),
            "__module__": f"{tree.name.partition('/')[0]}.{self._types.module_of(tree.name)}",
            "_md5sum": description.md5sum,
            "_full_text": description.definition,
            "_slot_types": [str(member.type) for member in tree.members],
            "_has_header": first is not None
            and (first.name, str(first.type)) == ("header", "std_msgs/Header"),
            "__hash__": None,
        }
        facade_class: Any = type(made.__name__, (Message,), namespace)
        for member in tree.members:
            # One slot has two names; the codec uses the name in the definition.
            setattr(facade_class, _python_name(member.name), vars(facade_class)[member.name])
        # A list: programs of users join and index it.
        facade_class.__slots__ = [_python_name(member.name) for member in tree.members]
        return facade_class  # type: ignore[no-any-return]


def _python_name(name: str) -> str:
    """Return the name of a field or constant in Python, as in genpy: the keyword `from` becomes `from_`."""
    return f"{name}_" if keyword.iskeyword(name) or name == "self" else name


class MessageTypes:
    """The types of a registry as classes; any thread may use it."""

    def __init__(self, registry: Registry) -> None:
        self.registry = registry
        self._store = TypeStore(registry, FacadeClasses(self))
        self._services: dict[str, type[ServiceClass]] = {}
        self._codecs: dict[str, Codec] = {}
        self._lock = threading.RLock()

    @cached_property
    def packages(self) -> frozenset[str]:
        """The packages that have definitions."""
        return frozenset(self.registry.packages())

    def codec(self, name: str) -> Codec:
        """Return a message's codec. Raises UnknownTypeError, DefinitionError."""
        with self._lock:
            codec = self._codecs.get(name)
            if codec is None:
                codec = self._store.codec(name)
                made: Any = codec.message_class
                made._codec = codec
                for member in codec.tree.members:
                    nested = getattr(member.node, "element", member.node)
                    if isinstance(nested, Struct):
                        self.codec(nested.name)
                self._codecs[name] = codec
            return codec

    def message_class(self, name: str) -> type[Message]:
        """Return the class of `package/Name`. Raises UnknownTypeError, DefinitionError."""
        made: Any = self.codec(name).message_class
        return made  # type: ignore[no-any-return]

    def service_class(self, name: str) -> type[ServiceClass]:
        """Return the class of a service. Raises UnknownTypeError, DefinitionError."""
        with self._lock:
            if name not in self._services:
                description = self.registry.service_type(name)
                package, _, short_name = name.partition("/")
                self._services[name] = type(
                    short_name,
                    (ServiceClass,),
                    {
                        "__module__": f"{package}.srv",
                        "_type": name,
                        "_md5sum": description.md5sum,
                        "_request_class": self.message_class(description.request.name),
                        "_response_class": self.message_class(description.response.name),
                    },
                )
            return self._services[name]

    def module_of(self, message_name: str) -> str:
        """Return `srv` for requests and responses, else `msg`."""
        service = service_of(message_name)
        return "srv" if service and service in self.registry.services(service.partition("/")[0]) else "msg"


def message_type_of(message_class: type[Message]) -> MessageType:
    """Return the type of a message class, as in a connection header."""
    if issubclass(message_class, AnyMsg):
        return MessageType(AnyMsg._type, AnyMsg._md5sum)
    return MessageType(message_class._type, message_class._md5sum, message_class._full_text)


def service_type_of(service_class: type[ServiceClass]) -> ServiceType:
    """Return the type of a service class, as in a connection header."""
    return ServiceType(
        service_class._type,
        service_class._md5sum,
        message_type_of(service_class._request_class),
        message_type_of(service_class._response_class),
    )


_types: MessageTypes | None = None
_types_lock = threading.Lock()


def all_types() -> MessageTypes:
    """Return the types of this process: those of its packages, and the bundled ones."""
    global _types
    with _types_lock:
        if _types is None:
            _types = MessageTypes(Registry(package_path=package_search_path(os.environ)))
        return _types


def get_message_class(message_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of a message type, or None if the type is unknown."""
    if message_type in ("time", "duration"):
        return Time if message_type == "time" else Duration
    try:
        return all_types().message_class("std_msgs/Header" if message_type == "Header" else message_type)
    except DefinitionError:
        return None


def get_service_class(service_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of a service type, or None if the type is unknown."""
    try:
        return all_types().service_class(service_type)
    except DefinitionError:
        return None


def generate_dynamic(core_type: str, msg_cat: str) -> dict[str, type[Message]]:
    """Return the classes of a type and of the types in its full text, by name. Raises DefinitionError."""
    registry = Registry.of_full_text(core_type, msg_cat)
    types = MessageTypes(registry)
    return {name: types.message_class(name) for name in registry.messages()}

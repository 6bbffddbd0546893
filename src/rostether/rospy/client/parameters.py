"""The functions of rospy for the parameters of the master, and the master's API."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.names import names
from rostether.rospy.client.node import node

_UNSPECIFIED: Any = object()


def get_param(param_name: str, default: Any = _UNSPECIFIED) -> Any:
    """Return a parameter's value, or `default` if it is not set.

    Raises KeyError if it is not set and there is no default, ROSException.
    """
    try:
        return _in_python(node.call(node.master().get_param(names.resolve(param_name))))
    except UnknownNameError:
        if default is _UNSPECIFIED:
            raise KeyError(param_name) from None
        return default


def get_param_cached(param_name: str, default: Any = _UNSPECIFIED) -> Any:
    """Return a parameter's value, like `get_param`: nothing is cached. Raises the same errors."""
    return get_param(param_name, default)


def get_param_names() -> list[str]:
    """Return the names of all parameters. Raises ROSException."""
    return node.call(node.master().param_names())


def set_param(param_name: str, param_value: Any) -> None:
    """Set a parameter; a dict replaces all parameters below the name.

    Raises ROSException, and ValueError for a value that no parameter can have, such as None.
    """
    try:
        node.call(node.master().set_param(names.resolve(param_name), _for_master(param_value)))
    except GraphError as error:
        raise ROSException(f"{error}") from None


def has_param(param_name: str) -> bool:
    """Return whether a parameter is set. Raises ROSException."""
    return node.call(node.master().has_param(names.resolve(param_name)))


def delete_param(param_name: str) -> None:
    """Delete a parameter. Raises KeyError if it is not set, ROSException."""
    try:
        node.call(node.master().delete_param(names.resolve(param_name)))
    except UnknownNameError:
        raise KeyError(param_name) from None


def search_param(param_name: str) -> str | None:
    """Return the full name of the parameter in the nearest namespace, or None. Raises ROSException."""
    return node.call(node.master().search_param(names.mappings.get(param_name, param_name)))


# Methods of the master whose first argument is a name.
_RESOLVED = frozenset(
    {
        "deleteParam",
        "setParam",
        "getParam",
        "searchParam",
        "subscribeParam",
        "unsubscribeParam",
        "hasParam",
        "registerService",
        "lookupService",
        "unregisterService",
        "registerSubscriber",
        "unregisterSubscriber",
        "registerPublisher",
        "unregisterPublisher",
        "lookupNode",
        "getPublishedTopics",
    }
)


class MasterProxy:
    """The master's API as methods that return `[code, text, value]`, and the parameters as a mapping.

    The methods raise ROSException, and ValueError for an argument that XML-RPC cannot carry.
    """

    def __init__(self, uri: str, caller_id: str | None = None) -> None:
        self._caller_id = caller_id
        self._client = XmlRpcClient(uri, peer="the ROS master", unreachable=MasterUnreachableError)

    def __getattr__(self, method: str) -> Any:
        if method.startswith("_"):
            raise AttributeError(method)

        def call(*args: Any) -> list[Any]:
            if method in _RESOLVED and args:
                args = (names.resolve(args[0]), *args[1:])
            caller_id = self._caller_id or names.caller_id
            answer = node.call(self._client.call_status(method, caller_id, *map(_for_master, args)))
            return [_in_python(each) for each in answer]

        return call

    def search_param(self, key: str) -> str | None:
        """Return the full name of the parameter in the nearest namespace, or None. Raises ROSException."""
        return search_param(key)

    def __getitem__(self, key: str) -> Any:
        return get_param(key)

    def __setitem__(self, key: str, val: Any) -> None:
        set_param(key, val)

    def __delitem__(self, key: str) -> None:
        delete_param(key)

    def __contains__(self, key: str) -> bool:
        return has_param(key)

    def __iter__(self) -> Iterator[str]:
        return iter(get_param_names())


def get_master(env: object = None) -> MasterProxy:
    """Return the API of this program's master; `env` has no effect."""
    return MasterProxy(node.environment().master_uri)


def get_published_topics(namespace: str = "/") -> list[list[str]]:
    """Return the names and types of published topics below a namespace. Raises ROSException."""
    code, text, value = get_master().getPublishedTopics(namespace)
    if code != 1:
        raise ROSException(f"unable to get published topics: {text}")
    return [list(each) for each in value]


def _for_master(value: Any) -> Any:
    """Return a value with the binary data of xmlrpc.client as bytes, and tuples as lists."""
    if isinstance(value, dict):
        return {name: _for_master(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_for_master(each) for each in value]
    return value.data if type(value).__module__ == "xmlrpc.client" and hasattr(value, "data") else value


def _in_python(value: Any) -> Any:
    """Return a value with bytes as binary data of xmlrpc.client, because programs read its `.data`."""
    if isinstance(value, dict):
        return {name: _in_python(each) for name, each in value.items()}
    if isinstance(value, list):
        return [_in_python(each) for each in value]
    if isinstance(value, bytes):
        from xmlrpc.client import Binary

        return Binary(value)
    return value

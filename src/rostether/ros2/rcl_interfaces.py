"""The interfaces of every ROS 2 node (rcl_interfaces) in the form of ROS 1, which the graph port carries.

A ROS 2 graph finds the ROS 2 definitions with the same names, and converts between both.
"""

from __future__ import annotations

from functools import cache

from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.registry import Registry
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore

PACKAGE = "rcl_interfaces"

_MESSAGES = {
    "FloatingPointRange": "float64 from_value\nfloat64 to_value\nfloat64 step\n",
    "IntegerRange": "int64 from_value\nint64 to_value\nuint64 step\n",
    "ListParametersResult": "string[] names\nstring[] prefixes\n",
    "Log": """time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
""",
    "Parameter": "string name\nParameterValue value\n",
    "ParameterDescriptor": """string name
uint8 type
string description
string additional_constraints
bool read_only
bool dynamic_typing
FloatingPointRange[] floating_point_range
IntegerRange[] integer_range
""",
    "ParameterEvent": """time stamp
string node
Parameter[] new_parameters
Parameter[] changed_parameters
Parameter[] deleted_parameters
""",
    "ParameterValue": """uint8 type
bool bool_value
int64 integer_value
float64 double_value
string string_value
byte[] byte_array_value
bool[] bool_array_value
int64[] integer_array_value
float64[] double_array_value
string[] string_array_value
""",
    "SetParametersResult": "bool successful\nstring reason\n",
}

_SERVICES = {
    "DescribeParameters": "string[] names\n---\nParameterDescriptor[] descriptors\n",
    "GetParameters": "string[] names\n---\nParameterValue[] values\n",
    "GetParameterTypes": "string[] names\n---\nuint8[] types\n",
    "ListParameters": "string[] prefixes\nuint64 depth\n---\nListParametersResult result\n",
    "SetParameters": "Parameter[] parameters\n---\nSetParametersResult[] results\n",
    "SetParametersAtomically": "Parameter[] parameters\n---\nSetParametersResult result\n",
}


class RclInterfaces:
    """Types and codecs by their short names; those of a service have the suffix `Request` or `Response`."""

    def __init__(self) -> None:
        self._registry = Registry(bundled=False)
        self.add_to(self._registry)
        self._store = TypeStore(self._registry)

    def message(self, name: str) -> MessageType:
        """Return a message's type."""
        return self._registry.message_type(f"{PACKAGE}/{name}")

    def service(self, name: str) -> ServiceType:
        """Return a service's type."""
        return self._registry.service_type(f"{PACKAGE}/{name}")

    def codec(self, name: str) -> Codec:
        """Return the codec of a message, a request or a response."""
        return self._store.codec(f"{PACKAGE}/{name}")

    def add_to(self, registry: Registry) -> None:
        """Add these types to another registry, so that its users can call the services of every node."""
        for name, text in _MESSAGES.items():
            registry.add_full_text(f"{PACKAGE}/{name}", text)
        for name, text in _SERVICES.items():
            registry.add_service_text(f"{PACKAGE}/{name}", text)


@cache
def rcl_interfaces() -> RclInterfaces:
    """Return the only instance of this process."""
    return RclInterfaces()

"""The bundled services as classes: `from rostether.srv.std_srvs import SetBool, SetBoolResponse`.

Type checkers know the fields of the request and of the response, which are those of ROS 1. A workspace's
own services have no classes here: name them by type (`"my_msgs/Move"`).
"""

from __future__ import annotations

from functools import cache

from rostether.errors import UnknownTypeError
from rostether.serde.class_modules import add_class_modules, bundled_store
from rostether.serde.type_classes import Service
from rostether.serde.values import Message


@cache
def _find(name: str) -> type[Message | Service[Message, Message]]:
    store = bundled_store()
    try:
        store.registry.service_type(name)
    except UnknownTypeError:
        if not name.endswith(("Request", "Response")):
            raise
        return store.codec(name).message_class
    return type(name.rpartition("/")[2], (Service,), {"_type": name})


add_class_modules(globals(), _find, "service")

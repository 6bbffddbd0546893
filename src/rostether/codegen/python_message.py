"""Generates the MicroPython module of a message or service: classes with `serialize` and `deserialize`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from math import isfinite

from rostether.codegen.python_fields import TIME_CLASSES, PythonField, reading, writing
from rostether.codegen.python_names import class_name, member_names, package_name
from rostether.msgdef.md5sum import message_md5sum
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import Constant, Field, MessageSpec, ServiceSpec
from rostether.serde.layout import smallest_size
from rostether.serde.type_tree import TypeTrees

# Maps the full name of a message to the path of its module without `.py`.
PathOf = Callable[[str], str]


def message_module(spec: MessageSpec, registry: Registry, path_of: PathOf) -> str:
    """Return the text of a message's module."""
    return _module(spec.full_name, [spec], registry, path_of, list(_class(spec, spec.full_name, registry)))


def service_module(spec: ServiceSpec, registry: Registry, path_of: PathOf) -> str:
    """Return the text of a service's module; request and response both announce the service's name."""
    messages = spec.request, spec.response
    lines = [line for message in messages for line in (*_class(message, spec.full_name, registry), "", "")]
    request, response = (class_name(message.name) for message in messages)
    lines += [f"class {class_name(spec.name)}:", f"    Request = {request}", f"    Response = {response}"]
    return _module(spec.full_name, list(messages), registry, path_of, lines)


def _module(
    full_name: str, specs: list[MessageSpec], registry: Registry, path_of: PathOf, classes: list[str]
) -> str:
    bases = {each.type.base for spec in specs for each in spec.fields}
    imports = ["from struct import pack_into as _pack", "from struct import unpack_from as _unpack"]
    for base in sorted(each for each in bases if "/" in each):
        module = path_of(base).replace("/", ".")
        imports.append(f"from {module} import {class_name(registry.message(base).name)} as {_alias(base)}")
    imports += ["from ros.message import Message as _Message", "from ros.message import repeat as _repeat"]
    imports += [
        f"from ros.times import {name.removeprefix('_')} as {name}"
        for base, name in TIME_CLASSES.items()
        if base in bases
    ]
    text = "\n".join(classes)
    used = [each for each in imports if re.search(rf"\b{each.rpartition(' ')[2]}\b", text)]
    head = f"# Generated from {full_name} by rostether; changes are lost when the library is generated again."
    return "\n".join([head, "", *used, "", "", text, ""])


def _class(spec: MessageSpec, type_name: str, registry: Registry) -> Iterator[str]:
    names = member_names(spec)
    trees = TypeTrees(registry)
    fields = [_field(each, names[each.name], trees) for each in spec.fields]
    yield f"class {class_name(spec.name)}(_Message):"
    yield f'    _type = "{type_name}"'
    yield f'    _md5sum = "{message_md5sum(spec, registry.message)}"'
    # If a constant is declared twice, the last value is used.
    constants = {each.name: each for each in spec.constants}
    yield from (f"    {names[each.name]} = {_value(each)}" for each in constants.values())
    if fields:
        yield ""
        yield f"    def __init__(self, {', '.join(f'{each.name}={each.default()}' for each in fields)}):"
        for each in fields:
            value = each.name
            if each.default() == "None":
                value = f"{each.initial()} if {each.name} is None else {each.name}"
            yield f"        self.{each.name} = {value}"
    for method, argument, statements in (
        ("serialize", "writer", writing(fields)),
        ("deserialize", "reader", reading(fields)),
    ):
        yield ""
        yield f"    def {method}(self, {argument}):"
        lines = list(statements) or ["pass"]
        yield from (f"        {line}" for line in lines)


def _field(field: Field, name: str, trees: TypeTrees) -> PythonField:
    base = field.type.base
    if "/" in base:
        return PythonField(field, name, _alias(base), smallest_size(trees.struct(base)))
    return PythonField(field, name, TIME_CLASSES.get(base, ""), 8)


def _alias(full_name: str) -> str:
    """Return a name that no field and no class can have, because it begins with an underscore."""
    package, _, name = full_name.partition("/")
    return f"_{package_name(package)}_{name}"


def _value(constant: Constant) -> str:
    if isinstance(constant.value, float) and not isfinite(constant.value):
        return f'float("{constant.value}")'
    return ascii(constant.value)

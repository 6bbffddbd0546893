"""How two definitions of one message differ, in one line for a person."""

from __future__ import annotations

from collections.abc import Iterable

from rostether.msgdef.spec import Constant, Field, MessageSpec

# A definition with more differences is simply another one; the line stays readable.
_MAX_LISTED = 6


def difference(ours: MessageSpec, theirs: MessageSpec) -> str:
    """Describe what `theirs` lacks, adds or declares otherwise; empty if all declarations are the same."""
    differences = [
        *_field_differences(ours.fields, theirs.fields),
        *_constant_differences(ours.constants, theirs.constants),
    ]
    if not differences and (ours.fields, ours.constants) != (theirs.fields, theirs.constants):
        differences = [_order_difference(ours, theirs)]
    if len(differences) > _MAX_LISTED:
        differences[_MAX_LISTED:] = [f"and {len(differences) - _MAX_LISTED} more differences"]
    return ", ".join(differences)


def declarations(spec: MessageSpec) -> str:
    """Return the fields as one line: `Header header, float32 range`."""
    return _listed(spec.fields) or "no fields"


def _field_differences(ours: Iterable[Field], theirs: Iterable[Field]) -> Iterable[str]:
    our_types = {field.name: field.type for field in ours}
    their_types = {field.name: field.type for field in theirs}
    for name, type_ in our_types.items():
        if name not in their_types:
            yield f"lacks '{type_} {name}'"
        elif str(their_types[name]) != str(type_):
            yield f"has '{their_types[name]} {name}' for '{type_} {name}'"
    for name, type_ in their_types.items():
        if name not in our_types:
            yield f"has '{type_} {name}' more"


def _constant_differences(ours: Iterable[Constant], theirs: Iterable[Constant]) -> Iterable[str]:
    our_texts = {constant.name: f"{constant.type} {constant.name}={constant.text}" for constant in ours}
    their_texts = {constant.name: f"{constant.type} {constant.name}={constant.text}" for constant in theirs}
    for name, text in our_texts.items():
        if name not in their_texts:
            yield f"lacks the constant '{text}'"
        elif their_texts[name] != text:
            yield f"has '{their_texts[name]}' for '{text}'"
    for name, text in their_texts.items():
        if name not in our_texts:
            yield f"has the constant '{text}' more"


def _order_difference(ours: MessageSpec, theirs: MessageSpec) -> str:
    if ours.fields == theirs.fields:
        return "declares the constants in another order"
    return f"declares the fields in another order: {_listed(theirs.fields)}"


def _listed(fields: Iterable[Field]) -> str:
    texts = [f"{field.type} {field.name}" for field in fields]
    if len(texts) > _MAX_LISTED:
        texts[_MAX_LISTED:] = [f"and {len(texts) - _MAX_LISTED} more fields"]
    return ", ".join(texts)

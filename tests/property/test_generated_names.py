"""For any names in a definition, the generated class has all members, with unique names."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rostether.codegen.cpp_names import class_name, is_variable_array, name_members
from rostether.codegen.message_headers import message_header
from rostether.codegen.reserved_words import MEMBERS_OF_EVERY_MESSAGE, is_macro_in_sketches, keywords
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.spec import MessageSpec
from unit.codegen.compilers import COMPILERS

STEMS = (
    "x",
    "class",
    "HIGH",
    "B1",
    "data",
    "serialize",
    "Foo",
    "min",
    "uint8_t",
    "fields",
    "x_length",
    "near",
)
TYPES = ("uint8", "float64", "string", "time", "int64[]", "string[]", "float64[]", "bool[3]", "float32[0]")
CONSTANTS = (("uint8", "1"), ("float64", "1e300"), ("string", 'a "b" \\'), ("int64", "-9223372036854775808"))
CLASSES_PER_FILE = 12

names = st.builds(
    lambda stem, tail: stem + tail,
    st.sampled_from(STEMS),
    st.sampled_from(("", "_", "__", "_length", "_type")),
)
fields = st.lists(st.tuples(st.sampled_from(TYPES), names), max_size=12, unique_by=lambda field: field[1])
constants = st.lists(
    st.tuples(st.sampled_from(CONSTANTS), st.one_of(names, names.map(lambda name: f"_{name}"))), max_size=6
)


@st.composite
def specs(draw: st.DrawFn, name: str = "Foo") -> MessageSpec:
    lines = [f"{kind} {constant}={value}" for (kind, value), constant in draw(constants)]
    lines += [f"{kind} {field}" for kind, field in draw(fields)]
    return parse_message("\n".join(lines), package="pkg", name=name)


@settings(deadline=None)
@given(specs())
def test_members_have_unique_names(spec: MessageSpec) -> None:
    names_of_members = name_members(spec)
    members = [class_name(spec.name), *MEMBERS_OF_EVERY_MESSAGE, *names_of_members.fields]
    members += [f"_{name}_type" for name in names_of_members.fields]
    members += [
        f"{name}_length"
        for field, name in zip(spec.fields, names_of_members.fields, strict=True)
        if is_variable_array(field)
    ]
    members += [each.name for each in names_of_members.constants]
    members += [each.alias for each in names_of_members.constants if each.alias is not None]
    assert len(members) == len(set(members))
    assert not keywords().intersection(members)
    assert not any(map(is_macro_in_sketches, names_of_members.fields))
    assert all(
        name.rstrip("_") == field.name.rstrip("_")
        for field, name in zip(spec.fields, names_of_members.fields, strict=True)
    )


@pytest.mark.parametrize(
    "compiler", [pytest.param(name, marks=getattr(pytest.mark, name)) for name in ("gcc", "avr")]
)
@settings(deadline=None, max_examples=8, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_generated_classes_compile(
    compiler: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    from rostether.codegen.library_source import client_library

    folder = tmp_path_factory.mktemp("headers")
    source = folder / "all.cpp"
    drawn = [data.draw(specs(name=f"Foo{number}")) for number in range(CLASSES_PER_FILE)]
    source.write_text("".join(message_header(spec, "0" * 32) for spec in drawn))
    assert not COMPILERS[compiler].compile(source, Path(client_library()))

"""Properties of every definition text, full text and name."""

from __future__ import annotations

import string

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from effort import effort
from rostether.errors import ConfigError, DefinitionError, InvalidNameError
from rostether.msgdef.full_text import SEPARATOR, message_full_text, split_full_text
from rostether.msgdef.md5sum import message_md5sum
from rostether.msgdef.mismatch import explain_mismatch
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import expand_action, parse_service
from rostether.msgdef.primitives import INTEGER_RANGES, PRIMITIVE_TYPES
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec
from rostether.names.graph_name import is_legal_name, join, namespace_of, resolve_name
from rostether.names.remap import parse_arguments
from rostether.packages.package_xml import parse_package_xml

# On a busy machine, single examples may be slow. This is not a failure.
without_deadline = settings(
    max_examples=effort(20, 60), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)

BUNDLED = Registry()
BUNDLED_NAMES = BUNDLED.messages()

identifiers = st.text(string.ascii_letters + string.digits + "_", min_size=1, max_size=10).filter(
    lambda text: text[0] in string.ascii_letters
)
field_types = st.sampled_from([*sorted(PRIMITIVE_TYPES), "Header", *BUNDLED_NAMES])
arrays = st.sampled_from(["", "", "[]", "[0]", "[1]", "[9]"])
fields = st.tuples(field_types, arrays).map("".join)
blanks = st.text(" \t", min_size=1, max_size=3)
comments = st.one_of(st.just(""), st.text(st.characters(codec="utf-8", exclude_characters="\n"), max_size=9))
line_like = st.one_of(
    st.text(max_size=30),
    st.lists(
        st.sampled_from(
            ["int8", "string", "Header", "[3]", "[", "a", "B", "=", "==", "1", "1e-3", " ", "#", "\t"]
        )
    ).map("".join),
)


@st.composite
def integer_constants(draw: st.DrawFn) -> str:
    type_name = draw(st.sampled_from(sorted(INTEGER_RANGES)))
    value = draw(st.integers(*INTEGER_RANGES[type_name]))
    return f"{type_name} {draw(identifiers)}={value}"


@st.composite
def definitions(draw: st.DrawFn) -> tuple[str, list[tuple[str, str]]]:
    """Draw a valid text and the fields that it declares."""
    names = draw(st.lists(identifiers, unique=True, max_size=8))
    declared = [(draw(fields), name) for name in names]
    lines: list[str] = []
    for type_text, name in declared:
        if draw(st.booleans()):
            lines.append(draw(st.one_of(st.just(""), integer_constants(), comments.map("#{}".format))))
        indent, gap = draw(st.sampled_from(["", " ", "\t"])), draw(blanks)
        lines.append(f"{indent}{type_text}{gap}{name} #{draw(comments)}")
    return "\n".join(lines), declared


def parse(text: str) -> MessageSpec:
    return parse_message(text, package="p", name="N")


def resolved(type_text: str) -> str:
    if type_text == "Header":
        return "std_msgs/Header"
    # `Header[]` refers to a type of the message's package, as in genmsg.
    return f"p/{type_text}" if type_text.startswith("Header[") else type_text


@without_deadline
@given(definitions())
def test_every_legal_text_gives_its_fields(drawn: tuple[str, list[tuple[str, str]]]) -> None:
    text, declared = drawn
    spec = parse(text)
    assert [(str(field.type), field.name) for field in spec.fields] == [
        (resolved(type_text), name) for type_text, name in declared
    ]


@without_deadline
@given(definitions())
def test_comments_and_blanks_do_not_change_the_md5sum(drawn: tuple[str, list[tuple[str, str]]]) -> None:
    text, declared = drawn
    assume(not any(type_text.startswith("Header[") for type_text, _ in declared))
    spec = parse(text)
    bare = [f"{c.type} {c.name}={c.text}" for c in spec.constants]
    bare += [f"{field.type} {field.name}" for field in spec.fields]
    assert message_md5sum(spec, BUNDLED.message) == message_md5sum(parse("\n".join(bare)), BUNDLED.message)


@without_deadline
@given(definitions())
def test_a_full_text_gives_the_same_definition(drawn: tuple[str, list[tuple[str, str]]]) -> None:
    text, declared = drawn
    assume(not any(type_text.startswith("Header[") for type_text, _ in declared))
    assume(SEPARATOR not in text)
    spec = parse(text)
    definition = message_full_text(spec, BUNDLED.message)
    learned = Registry(bundled=False)
    learned.add_full_text("p/N", definition)
    assert learned.message("p/N").text == text
    assert learned.message_type("p/N").md5sum == message_md5sum(spec, BUNDLED.message)
    assert learned.message_type("p/N").definition == definition


@without_deadline
@given(st.lists(line_like, max_size=8).map("\n".join))
def test_garbage_is_refused_with_its_place_or_read(text: str) -> None:
    for read in (
        lambda: parse_message(text, package="p", name="N"),
        lambda: parse_service(text, package="p", name="N"),
        lambda: expand_action(text, name="N"),
    ):
        try:
            read()
        except DefinitionError as error:
            assert "\n" not in str(error)
            assert error.file


@without_deadline
@given(st.text(max_size=200))
def test_a_string_constant_has_all_text_after_the_equals_sign(value: str) -> None:
    assume("\n" not in value)
    (constant,) = parse(f"string X={value}").constants
    assert constant.value == value.strip()


@without_deadline
@given(
    st.text(max_size=20), st.lists(st.one_of(st.text(max_size=20), st.sampled_from([SEPARATOR, "MSG: a/B"])))
)
def test_garbage_from_a_peer_is_refused_or_added_completely(name: str, lines: list[str]) -> None:
    registry = Registry(bundled=False)
    try:
        registry.add_full_text(name, "\n".join(lines))
    except DefinitionError:
        assert registry.messages() == []
    else:
        assert name in registry.messages()


@without_deadline
@given(st.text(max_size=300))
def test_any_full_text_is_split(definition: str) -> None:
    assert split_full_text("p/N", definition)["p/N"] is not None


@without_deadline
@given(st.sampled_from(BUNDLED_NAMES), st.data())
def test_a_missing_field_is_always_reported(name: str, data: st.DataObject) -> None:
    spec = BUNDLED.message(name)
    assume(spec.fields)
    dropped = data.draw(st.sampled_from(spec.fields))
    lines = [f"{c.type} {c.name}={c.text}" for c in spec.constants]
    lines += [f"{field.type} {field.name}" for field in spec.fields if field != dropped]
    older = parse_message("\n".join(lines), package=spec.package, name=spec.name)
    line = explain_mismatch(BUNDLED, name, message_md5sum(older, BUNDLED.message))
    assert f"lacks '{dropped.type} {dropped.name}'" in line or "it belongs to" in line


names = st.text("ab1_/~", max_size=8)


@without_deadline
@given(names, names)
def test_resolved_names_are_global_legal_and_stable(name: str, namespace: str) -> None:
    try:
        full_name = resolve_name(name, namespace="/ns", node_name="/ns/node")
    except InvalidNameError as error:
        assert not is_legal_name(name)
        assert "\n" not in str(error)
        return
    assert full_name.startswith("/")
    assert is_legal_name(full_name)
    assert resolve_name(full_name, namespace="/other", node_name="/other/node") == full_name
    assert namespace_of(join(full_name, "x")) == full_name


@without_deadline
@given(
    st.lists(st.one_of(st.text(max_size=20), st.sampled_from(["a:=b", "_p:=[", "_p:=1", "__name:=x", "--y"])))
)
def test_arguments_raise_only_config_errors(argv: list[str]) -> None:
    try:
        parsed = parse_arguments(argv)
    except ConfigError as error:
        assert "\n" not in str(error)
        return
    assert set(parsed.rest) <= set(argv)


@without_deadline
@given(
    st.one_of(
        st.binary(max_size=200),
        st.text(max_size=100).map("<package><name>{}</name></package>".format).map(str.encode),
    )
)
def test_package_files_raise_only_config_errors(data: bytes) -> None:
    try:
        assert parse_package_xml(data).name
    except ConfigError as error:
        assert "\n" not in str(error)

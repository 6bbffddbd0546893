"""A launch file with any content is read, or refused with the position of the error."""

from __future__ import annotations

from hypothesis import example, given, settings
from hypothesis import strategies as st

from effort import effort
from rostether.errors import ConfigError, LaunchError
from rostether.launch.loading import load_launch
from rostether.launch.scope import Scope
from rostether.launch.substitution import LaunchContext, substitute
from rostether.launch.values import convert

CONTEXT = LaunchContext({"HOME": "/home/x"}, {})
TOKENS = st.sampled_from(
    [
        "$(",
        "$",
        "(",
        ")",
        "arg",
        "env",
        "optenv",
        "find",
        "anon",
        "dirname",
        "eval",
        " ",
        "x",
        "HOME",
        "'",
        "+",
    ]
)
PIECES = st.sampled_from(
    [
        *("<group ns='a'>", "</group>", "<node name='n' pkg='p' type='t'>", "</node>", "<param name='x' "),
        *("value='$(arg x)'/>", "value='1'/>", "<rosparam>", "{a: [1", "]}", "</rosparam>", "<arg name='x' "),
        *(
            "default='1'/>",
            "<remap from='a' to='b'/>",
            "<env name='a' value='b'/>",
            " if='0'",
            "text",
            "&amp;",
        ),
        *("<test test-name='t' pkg='p' type='t'/>", "<include file='/dev/null'/>", "<!-- c -->", "<![CDATA["),
    ]
)


def load_or_refuse(body: bytes) -> None:
    """Load a launch file; an error has one line and the file."""
    try:
        load_launch([], {"x": "1"}, LaunchContext({}, {}), text=body)
    except LaunchError as error:
        assert "\n" not in str(error)
        assert error.file


@given(st.binary(max_size=200))
def test_any_bytes_are_loaded_or_refused(body: bytes) -> None:
    load_or_refuse(body)


@settings(max_examples=effort(100, 300))
@given(st.lists(PIECES, max_size=12))
@example(["<param name='x' ", "value='$(arg x)'/>"])
def test_any_pieces_of_launch_files_are_loaded_or_refused(pieces: list[str]) -> None:
    load_or_refuse(f"<launch>{''.join(pieces)}</launch>".encode())


@settings(max_examples=effort(100, 300))
@given(st.lists(TOKENS | st.text(max_size=3), max_size=12).map("".join))
def test_any_substitutions_are_replaced_or_refused(text: str) -> None:
    scope = Scope(file="x.launch", arguments={"x": "1"})
    try:
        result = substitute(text, scope, CONTEXT)
    except (LaunchError, ConfigError) as error:
        assert "\n" not in str(error) or "\n" in text
    else:
        assert "$" in text or result == text


@given(st.text(max_size=12), st.sampled_from(["auto", "str", "int", "double", "bool", "yaml", "other"]))
def test_any_text_is_converted_or_refused(text: str, type_name: str) -> None:
    try:
        value = convert(text, type_name)
    except (LaunchError, ConfigError):
        return
    if type_name == "str":
        assert value == text

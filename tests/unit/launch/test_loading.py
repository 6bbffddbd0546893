"""Launch files: the corpus compared with roslaunch, errors with file and line, warnings, limits."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import LaunchError
from rostether.launch.files import BUILTIN_ROOT
from rostether.launch.loading import STDIN_NAME, load_launch
from rostether.launch.plan import LaunchPlan
from rostether.launch.substitution import LaunchContext
from unit.launch.corpus import RIGHT, ROBOT, WRONG, described, exact, expected, load

# The files whose error is in an included file.
IN_THE_INCLUDED = {"include_missing_argument": "args.xml:4", "include_fixed_argument": "fixed.xml:2"}
LINES = {
    "arg_unset": (3, "argument 'x' has no value; give x:=VALUE, or a default in its <arg>"),
    "node_twice": (3, "two nodes have the name /n, one at"),
    "no_space": (2, "write a space before 'output="),
    "not_closed": (3, "not XML: mismatched tag"),
    "find_missing_package": (2, "there is no package 'no_such_package'"),
    "param_failing_command": (2, "the command 'false' failed with code 1"),
    "rosparam_broken_file": (2, "broken.yaml:2:1: this is not YAML"),
    "eval_division": (2, "division by zero"),
    "include_itself": (2, "is included more than 50 levels deep; if it includes itself"),
}


def loads(body: str, arguments: dict[str, str] | None = None, **options: object) -> LaunchPlan:
    text = f"<launch>\n{body}\n</launch>".encode()
    context = LaunchContext({"PATH": "/usr/bin:/bin"}, {}, **options)  # type: ignore[arg-type]
    return load_launch([], arguments or {}, context, text=text)


@pytest.mark.parametrize("file", RIGHT, ids=lambda file: file.stem)
def test_plans_equal_the_recorded_results_of_roslaunch(file: Path) -> None:
    assert exact(described(load(file))) == exact(expected()[file.stem])


def test_corpus_is_large() -> None:
    assert len(RIGHT) >= 40
    assert len(WRONG) >= 40


@pytest.mark.parametrize("file", WRONG, ids=lambda file: file.stem)
def test_errors_are_one_line_with_file_and_line(file: Path) -> None:
    with pytest.raises(LaunchError) as caught:
        load(file)
    text = str(caught.value)
    place = IN_THE_INCLUDED.get(file.stem, f"{file.name}:")
    assert place in text.split(": ")[0] + ":"
    assert "\n" not in text
    assert caught.value.line > 0


@pytest.mark.parametrize("name", LINES)
def test_error_contains_line_and_reason(name: str) -> None:
    with pytest.raises(LaunchError) as caught:
        load(ROBOT / "wrong" / f"{name}.launch")
    line, words = LINES[name]
    assert caught.value.line == line
    assert words in str(caught.value)


def test_error_in_an_included_file_names_the_including_file() -> None:
    with pytest.raises(
        LaunchError, match=r"args\.xml:4: .*\(included at .*include_missing_argument\.launch:2\)"
    ):
        load(ROBOT / "wrong" / "include_missing_argument.launch")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("deprecated", "deprecated: use the other"),
        ("parent_conflict", "parameter /a/b is below /a"),
        ("names_that_warn", "'my-node' is not a ROS name"),
    ],
)
def test_harmless_mistakes_are_warnings_with_file_and_line(name: str, words: str) -> None:
    (warning,) = load(ROBOT / "launch" / f"{name}.launch").warnings
    assert f"{name}.launch:" in warning
    assert words in warning


def test_unknown_tags_and_attributes_cause_warnings() -> None:
    warnings = "\n".join(load(ROBOT / "launch" / "unknown_things.launch").warnings)
    for words in (
        "no attribute colour=",
        "<group> has no meaning",
        "<somewhat> is not a known tag",
        "<master>",
        "unit=",
    ):
        assert words in warnings


def test_document_type_is_refused_before_entities_are_read() -> None:
    bomb = b'<!DOCTYPE x [<!ENTITY a "aaaa">]>\n<launch><param name="x" value="&a;"/></launch>'
    with pytest.raises(LaunchError, match="DTD"):
        load_launch([], {}, LaunchContext({}, {}), text=bomb)


def test_a_file_that_includes_itself_twice_is_refused() -> None:
    with pytest.raises(LaunchError, match="is included more than 50 levels deep"):
        load_launch(
            [ROBOT / "wrong" / "include_itself.launch"], {}, LaunchContext({}, {"corpus_robot": ROBOT})
        )


def test_the_number_of_includes_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.launch.loading.MAX_INCLUDES", 3)
    included = tmp_path / "empty.launch"
    included.write_text("<launch/>")
    include = f'<include file="{included}"/>'
    load_launch([], {}, LaunchContext({}, {}), text=f"<launch>{include * 3}</launch>".encode())
    with pytest.raises(LaunchError, match="the launch files have more than 3 includes"):
        load_launch([], {}, LaunchContext({}, {}), text=f"<launch>{include * 4}</launch>".encode())


@pytest.mark.parametrize("value", ["3000000000", "-2147483649"])
def test_number_that_is_too_large_for_a_parameter_is_refused_with_file_and_line(value: str) -> None:
    with pytest.raises(LaunchError, match=rf"{STDIN_NAME}:2: parameter /x: .* 32 bits"):
        loads(f'<param name="x" value="{value}"/>')


def test_null_is_refused() -> None:
    with pytest.raises(LaunchError, match="null"):
        loads("<rosparam>x: null</rosparam>")


def test_another_machine_is_refused_with_the_next_step() -> None:
    with pytest.raises(
        LaunchError, match=r":2: machine 'arm' at 192\.0\.2\.7 is another machine.*ROS_MASTER_URI"
    ):
        loads('<machine name="arm" address="192.0.2.7"/>')


def test_files_and_arguments_are_listed() -> None:
    plan = load(ROBOT / "launch" / "include_pass_all.launch")
    assert [Path(file).name for file in plan.files] == ["include_pass_all.launch", "args.xml", "fixed.xml"]
    assert [each.name for each in plan.arguments.values()] == ["required", "optional", "extra"]
    assert load(ROBOT / "launch" / "include_recursive.launch").argument_names == {"count"}


def test_built_in_programs_replace_those_of_missing_packages() -> None:
    programs = {("xacro", "xacro"): ("printf", "%s")}
    for name in ("xacro", "xacro.py"):
        plan = loads(f'<param name="x" command="$(find xacro)/{name} model.xacro"/>', programs=programs)
        assert plan.parameters == {"/x": "model.xacro"}
    with pytest.raises(LaunchError, match="not installed") as caught:
        loads('<param name="x" command="$(find xacro)/other"/>', programs=programs)
    assert BUILTIN_ROOT not in str(caught.value)


def test_files_of_a_built_in_package_are_reported_as_missing() -> None:
    with pytest.raises(LaunchError, match="package joy is not installed; its nodes are built in"):
        loads('<include file="$(find joy)/launch/joy.launch"/>', builtin_packages=["joy"])


def test_later_file_replaces_parameters_of_an_earlier_one(tmp_path: Path) -> None:
    for name, value in (("a", 1), ("b", 2)):
        (tmp_path / name).write_text(f'<launch><param name="x" value="{value}"/></launch>')
    plan = load_launch([tmp_path / "a", tmp_path / "b"], {}, LaunchContext({}, {}))
    assert plan.parameters == {"/x": 2}


def test_errors_suggest_a_similar_package(tmp_path: Path) -> None:
    file = tmp_path / "x.launch"
    file.write_text('<launch><param name="x" value="$(find corpus_robt)"/></launch>')
    with pytest.raises(LaunchError, match=r"did you mean corpus_robot\?"):
        load_launch([file], {}, LaunchContext({}, {"corpus_robot": ROBOT}))


@pytest.mark.parametrize(
    "body",
    [
        '<node name="n" pkg="p" type="t" respawn="{}"/>',
        '<node name="n" pkg="p" type="t" respawn_delay="{}"/>',
        '<node name="n" pkg="p" type="t" output="{}"/>',
        '<node name="n" pkg="p" type="t" cwd="{}"/>',
        '<group if="{}"/>',
        '<param name="x" type="int" value="{}"/>',
        '<param name="x" type="{}" value="1"/>',
    ],
)
def test_errors_cut_long_values(body: str) -> None:
    with pytest.raises(LaunchError) as refusal:
        loads(body.format("x" * 5000))
    assert len(str(refusal.value)) < 500


def test_unbalanced_quote_in_args_is_refused() -> None:
    with pytest.raises(LaunchError, match=r":2: .*no closing quotation"):
        loads('<node name="n" pkg="p" type="t" args="&quot;open"/>')


def test_texts_have_a_limit() -> None:
    with pytest.raises(LaunchError, match="more than 10000000 steps"):
        loads("""<param name="x" value="$(eval 'a' * 10**10)"/>""")


def test_arguments_that_multiply_a_text_are_refused() -> None:
    lines = [f'<arg name="a{n}" default="{f"$(arg a{n - 1})" * 10}"/>' for n in range(1, 11)]
    with pytest.raises(LaunchError, match="longer than 4194304 characters"):
        loads(f'<arg name="a0" default="0123456789"/>{"".join(lines)}')


def test_all_texts_together_have_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.launch.tag.MAX_SUBSTITUTED_CHARS", 1000)
    params = "".join(f'<param name="p{n}" value="$(arg a)"/>' for n in range(11))
    with pytest.raises(LaunchError, match="more than 1000 characters;"):
        loads(f'<arg name="a" default="{"x" * 100}"/>{params}')


def test_a_command_with_endless_output_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.launch.parameter_tags.MAX_FILE_BYTES", 1000)
    with pytest.raises(LaunchError, match="prints more than 1000 bytes"):
        loads('<param name="p" command="yes"/>')
    assert loads('<param name="p" command="echo short"/>').parameters == {"/p": "short\n"}


def test_commands_run_only_if_their_output_is_needed(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    body = f'<param name="p" type="int" command="touch {mark}"/><arg name="a" default="1"/>'
    plan = loads(body, runs_commands=False)
    assert plan.parameters == {"/p": ""}
    assert plan.argument_names == frozenset(("a",))
    assert not mark.exists()
    with pytest.raises(LaunchError):
        loads(body)
    assert mark.exists()


@pytest.mark.parametrize("source", ["textfile", "binfile"])
def test_an_endless_file_is_refused(source: str) -> None:
    with pytest.raises(LaunchError, match="is larger than"):
        loads(f'<param name="p" {source}="/dev/zero"/>')


def test_node_without_a_name_gets_one_and_its_parameters_are_in_the_namespace() -> None:
    plan = loads('<node name="" pkg="p" type="talk" ns="g"><param name="x" value="1"/></node>')
    assert plan.parameters == {"/g/x": 1}
    assert plan.nodes[0].name.startswith("talk_")

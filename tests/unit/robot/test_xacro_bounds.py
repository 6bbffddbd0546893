"""The limits of xacro's expressions; the values are compared with those of the package xacro alone."""

from __future__ import annotations

from pathlib import Path

import pytest
import xacro

from rostether.errors import RobotModelError
from rostether.robot.xacro import expand_xacro

BOMBS = [
    *("10**10**9", "'x'*10**9", "[0]*10**9", "math.factorial(10**6)", "factorial(10**6)"),
    *("sorted([10**6], key=math.factorial)", "'x'.ljust(10**9)", "[0 for x in range(10**9)]"),
    *("python.sum(x for x in python.range(10**9))", "python.tuple(map(factorial, [10**6]))"),
]


def document(inside: str) -> str:
    return f'<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>'


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "robot.xacro"


def expand(file: Path, inside: str, **mappings: str) -> str:
    file.write_text(document(inside))
    return expand_xacro(file, mappings, packages={})


def refusal(file: Path, inside: str) -> str:
    with pytest.raises(RobotModelError) as caught:
        expand(file, inside)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f"{file.parent}")
    return str(caught.value)


@pytest.mark.parametrize("expression", BOMBS)
def test_endless_expressions_are_refused_everywhere(file: Path, expression: str) -> None:
    for inside in (
        f'<link name="${{{expression}}}"/>',
        f'<xacro:property name="p" value="${{{expression}}}"/><link name="${{p}}"/>',
        f'<xacro:property name="p" value="${{{expression}}}" lazy_eval="false"/>',
        f'<xacro:if value="${{{expression}}}"/>',
    ):
        assert "robot.xacro" in refusal(file, inside)


def test_the_error_names_the_limit_and_the_expression(file: Path) -> None:
    text = refusal(file, '<link name="${10**10**9}"/>')
    assert "a whole number of more than 1024 bits is too large" in text
    assert "when evaluating expression '10**10**9'" in text
    assert "simplify it" in refusal(file, "<link name=\"${'x'*10**9}\"/>")


@pytest.mark.parametrize("expression", ["10**10**9", "'x' * 10**9", "f'{1:>999999999}'", "[0] * 10**9"])
def test_eval_substitutions_are_bounded(file: Path, expression: str) -> None:
    refusal(file, f'<link name="$(eval {expression})"/>')


def test_a_macro_parameter_without_its_closing_quote_is_read_quickly(file: Path) -> None:
    refusal(file, f'<xacro:macro name="m" params="a:={"b" * 200}\'"/><xacro:m/>')


def test_separators_are_not_regular_expressions(file: Path) -> None:
    inside = '<xacro:property name="s" value="a]|(x+)+y["/><l n="${xacro.tokenize(\'x\' * 99, s)}"/>'
    assert "the separators" in refusal(file, inside)


def test_yaml_is_bounded(file: Path) -> None:
    bomb = "a0: &a0 [0,0,0,0,0,0,0,0,0,0]\n" + "".join(
        f"a{n}: &a{n} [{','.join([f'*a{n - 1}'] * 10)}]\n" for n in range(1, 9)
    )
    (file.parent / "bomb.yaml").write_text(bomb)
    for function in ("load_yaml", "xacro.load_yaml"):
        assert "aliases" in refusal(file, f"<link name=\"${{{function}('bomb.yaml')}}\"/>")


# What robots of the ROS packages write: numbers, text, lists, dictionaries, conditions, YAML, messages.
VALID = """
<xacro:arg name="side" default="left"/> <xacro:arg name="count" default="3"/>
<xacro:property name="radius" value="0.05"/> <xacro:property name="width" value="${2*radius + 0.01}"/>
<xacro:property name="lazy" value="${later * 2}"/> <xacro:property name="later" value="21"/>
<xacro:property name="names" value="${['a', 'b', 'c']}"/>
<xacro:property name="table" value="${dict(x=1.5, y=[1, 2, 3], z=dict(deep=True))}"/>
<xacro:property name="limits" value="${xacro.load_yaml('limits.yaml')}"/>
<xacro:property name="form" value="{:05.2f}|{}"/>
<xacro:property name="text" value="'quoted'"/> <xacro:property name="pi2" value="${pi/2}"/>
<a v="${lazy} ${width} ${-pi2} ${radians(90)} ${sqrt(2)} ${math.atan2(1, 2)} ${10**3 // 7 % 5}"/>
<b v="${names[1]} ${names[-1]} ${names[1:]} ${len(names)} ${' '.join(names)} ${'-'.join(map(str, [1, 2]))}"/>
<c v="${table['y'][0]} ${table['z']} ${'x' in table} ${table.get('q', 7)} ${list(table.keys())}"/>
<d v="${limits.joint.max} ${limits['joint']['min']} ${limits.list[0]} ${limits.angle} ${limits.inch}"/>
<e v="${'%.3f' % pi} ${form.format(pi, names)} ${f'yes' + text} ${str(1) + '_' + text.upper()}"/>
<f v="${1 if later > 20 else 2} ${not False and 3 or 4} ${'a' != text} ${1 &lt; 2 &lt; 3} ${None}"/>
<g v="${[x*x for x in range(4)]} ${python.sum([1, 2])} ${max(1, 2.5)} ${round(pi, 2)} ${sorted([2, 1])}"/>
<h v="${python.sorted(names, key=lambda n: n, reverse=True)} ${python.list(python.zip(names, [1, 2, 3]))}"/>
<i v="${xacro.arg('side')} $(arg side)_x $(eval count * 2) $(eval side + 'y')"/>
<j v="${python.isinstance(1, int)} ${xacro.tokenize('a,b; c')} ${xacro.tokenize('a|b', '|')} ${1e3} ${0x1f}"/>
<k v="$${escaped} $$(escaped) ${'$'}"/>
<xacro:macro name="wheel" params="name:=w at:='0 0 1' *block **more side:=^|none flag:=${True}">
  <link name="${name}_${side}"><xacro:insert_block name="block"/><o xyz="${at}"/></link>
  <xacro:insert_block name="more"/> <xacro:if value="${flag}"><on/></xacro:if>
</xacro:macro>
<xacro:wheel name="front"><inertia ixx="${radius**2 * 0.5}"/><two><three v="${width}"/></two></xacro:wheel>
<xacro:macro name="count" params="n"><step n="${n}"/>
  <xacro:if value="${n > 0}"><xacro:count n="${n-1}"/></xacro:if></xacro:macro>
<xacro:count n="$(arg count)"/> <xacro:unless value="${names == []}"><full/></xacro:unless>
<xacro:call macro="${'co' + 'unt'}" n="0"/> <xacro:element xacro:name="${text}" v="1"/>
"""
LIMITS = "joint: {max: 1.5, min: -1.5}\nlist: [1, {a: 2}]\nangle: !degrees 90\ninch: !inches 2*3\nnone: ~\n"


def test_valid_documents_expand_as_with_the_package_alone(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(file.parent)
    (file.parent / "limits.yaml").write_text(LIMITS)
    for mappings in ({}, {"side": "right", "count": "1"}):
        file.write_text(document(VALID))
        expected = xacro.process_file(str(file), mappings=dict(mappings)).toprettyxml(indent="  ")
        assert expand(file, VALID, **mappings) == expected
    # The limits end with the block.
    assert xacro.process_file(str(file)).toprettyxml(indent="  ").count("<step") == 5

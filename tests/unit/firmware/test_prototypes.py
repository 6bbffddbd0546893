"""Which functions get a prototype, its text, and its position."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.firmware.prototypes import find_prototypes

USE = "void setup() { use(); }\n"


def prototypes(text: str) -> list[tuple[int, str]]:
    """Return the line before which each prototype is, and its text without insignificant spaces."""
    return [
        (text.count("\n", 0, each.offset) + 1, each.text.replace(" ", "")) for each in find_prototypes(text)
    ]


@pytest.mark.parametrize(
    ("definition", "prototype"),
    [
        ("void use() { }", "voiduse();"),
        ("void use(void)\n{\n}", "voiduse(void);"),
        ("static inline int use(int a) { return a; }", "staticinlineintuse(inta);"),
        ("const char* use(const char* s) { return s; }", "constchar*use(constchar*s);"),
        ("unsigned long use() { return 1; }", "unsignedlonguse();"),
        ("void use(const std_msgs::Empty& m) { }", "voiduse(conststd_msgs::Empty&m);"),
        ("std::pair<int, int> use() { return {}; }", "std::pair<int,int>use();"),
        ("struct P use() { }", "structPuse();"),
        ("auto use() -> int { return 1; }", "autouse()->int;"),
        ("void use() noexcept { }", "voiduse()noexcept;"),
        ("__attribute__((noinline)) void use() { }", "__attribute__((noinline))voiduse();"),
        ("void __attribute__((noinline)) use() { }", "void__attribute__((noinline))use();"),
        ("template <class T> void use(T t) { }", "template<classT>voiduse(Tt);"),
        ("void use(int a[], int (*f)(int)) { }", "voiduse(inta[],int(*f)(int));"),
        ('extern "C" void use() { }', 'extern"C"voiduse();'),
        ('extern "C" {\nvoid use() { }\n}', 'extern"C"voiduse();'),
        ("void use() { /* } */ char c = '}'; const char* s = \"}\"; }", "voiduse();"),
        ('void use() { const char* s = R"x(}{)x"; }', "voiduse();"),
        ("void use /* why */ (int a, // one\n int b) { }", "voiduse(inta,intb);"),
    ],
)
def test_a_function_used_above_its_definition_gets_one(definition: str, prototype: str) -> None:
    assert prototypes(f"{USE}{definition}\n") == [(1, prototype)]


@pytest.mark.parametrize(
    "rest",
    [
        "void other() { }",
        "void Motor::use() { }",
        "namespace n { void use() { } }",
        "class use { int f() { return 1; } };",
        "struct S { void use() { } } s;",
        "int use = 3;",
        "int use[] = { 1, 2 };",
        "bool operator==(use a, use b) { return true; }",
        "ISR(TIMER1_COMPA_vect) { use(); }",
        "enum use { A, B };",
        "auto use = [](int a) { return a; };",
        "template <class T = int> void use(T t) { }",
        "#define use() other()",
        "void setup() { }\nvoid loop() { }",
        "Thing use{1, 2};",
        "typedef void (*use)(int);",
    ],
)
def test_other_statements_get_none(rest: str) -> None:
    assert prototypes(f"{USE}{rest}\n") == []


def test_a_function_that_is_used_only_below_gets_none() -> None:
    assert prototypes("void use() { }\n" + USE) == []


def test_declarations_of_the_sketch_are_not_repeated() -> None:
    assert prototypes('extern "C" void use(int a);\n' + USE + "void use(int b) { }\n") == []


def test_the_declaration_of_another_overload_is_not_enough() -> None:
    text = "void use(int a);\n" + USE + "void use(int a) { }\nvoid use(int a, int b) { }\n"
    assert prototypes(text) == [(2, "voiduse(inta,intb);")]


def test_a_callback_of_a_global_object_is_declared_before_it() -> None:
    text = (
        "#include <ros.h>\n"
        "int before;\n"
        'ros::Subscriber<std_msgs::Empty> sub("toggle", &use);\n'
        "void use(const std_msgs::Empty& m) { }\n"
    )
    assert prototypes(text) == [(3, "voiduse(conststd_msgs::Empty&m);")]


def test_a_type_of_the_sketch_is_declared_before_the_prototype() -> None:
    text = (
        "void first() { }\n"
        "struct Point { int x; };\n"
        "void second() { use(1); }\n"
        "Point use(int a) { return Point(); }\n"
    )
    assert prototypes(text) == [(3, "Pointuse(inta);")]


def test_a_method_of_the_same_name_is_not_a_use() -> None:
    text = (
        "class Motor { public: void use(); };\n"
        "Motor m;\n"
        "void setup() { m.use(); use(m); }\n"
        "void use(Motor& m) { }\n"
    )
    assert prototypes(text) == [(2, "voiduse(Motor&m);")]


def test_a_use_through_a_macro_counts_where_the_macro_is_used() -> None:
    text = "#define GO() use(1)\nint a;\nvoid setup() { GO(); }\nvoid use(int a) { }\n"
    assert prototypes(text) == [(3, "voiduse(inta);")]


def test_default_arguments_move_to_the_prototype() -> None:
    text = USE + "void use(int a = 3, Pair<int, int> b = {1, 2}) { }\n"
    found = find_prototypes(text)
    assert found[0].text.replace(" ", "") == "voiduse(inta=3,Pair<int,int>b={1,2});"
    assert [text[start:end] for start, end in found[0].moved] == ["= 3", "= {1, 2}"]


def test_a_macro_before_a_function_is_not_repeated() -> None:
    assert prototypes(USE + "REGISTER(thing)\nint use() { return 1; }\n") == [(1, "intuse();")]


@given(st.text(alphabet="au(){}[]<>;,=:#\"'\\/* \n", max_size=80))
def test_any_text_can_be_read(text: str) -> None:
    for each in find_prototypes(text):
        assert 0 <= each.offset <= len(text)

from __future__ import annotations

from pathlib import Path

from rostether.firmware.ino import InoFile, active_lines, add_prototypes, join, read_ino


def test_files_of_all_editors_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.ino"
    path.write_bytes(b"\xef\xbb\xbfint a;\r\nint b;\r// \xe9\n")
    assert read_ino(path).text == "int a;\nint b;\n// \udce9\n"


def test_each_file_begins_with_its_own_first_line() -> None:
    text = join([InoFile("/x/a.ino", "int a;"), InoFile('/x/b "b".ino', "int b;\n")])
    assert text == ('#include <Arduino.h>\n#line 1 "/x/a.ino"\nint a;\n#line 1 "/x/b \\"b\\".ino"\nint b;\n')


def test_lines_and_columns_stay_the_same() -> None:
    files = [
        InoFile("/x/a.ino", "int x; void setup() { f(); g(); }\nvoid f(int a = 3) { }\n"),
        InoFile("/x/b.ino", "\nvoid g() {}\n"),
    ]
    assert add_prototypes(files, None).splitlines() == [
        "#include <Arduino.h>",
        '#line 1 "/x/a.ino"',
        "int x; ",
        '#line 2 "/x/a.ino"',
        "void f ( int a = 3 );",
        "",
        '#line 2 "/x/b.ino"',
        "void g ( );",
        '#line 1 "/x/a.ino"',
        "       void setup() { f(); g(); }",
        "void f(int a    ) { }",
        '#line 1 "/x/b.ino"',
        "",
        "void g() {}",
    ]


def test_code_that_is_not_compiled_gets_no_prototype() -> None:
    files = [
        InoFile(
            "/x/a.ino", "void setup() { f(); }\n#if 0\nvoid f(Nowhere n) { }\n#else\nvoid f() { }\n#endif\n"
        )
    ]
    text = add_prototypes(files, {"/x/a.ino": {1, 5}})
    assert "void f ( );" in text
    assert "void f ( Nowhere n );" not in text


def test_the_preprocessor_shows_which_lines_are_compiled() -> None:
    core = '# 1 "u.cpp"\n# 1 "/usr/Arduino.h" 1\nint core;\n'
    output = core + '# 1 "/x/a.ino" 2\nint a;\n\n\nint d;\n# 20 "/x/a.ino"\nint t;\n'
    assert active_lines(output)["/x/a.ino"] == {1, 4, 20}

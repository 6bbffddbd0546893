from __future__ import annotations

from rostether.codegen.keywords import with_classes


def test_classes_are_added_once_and_sorted() -> None:
    library = "# words\nNodeHandle\tKEYWORD1\nString\tKEYWORD1\nadvertise\tKEYWORD2\n"
    assert with_classes(library, ["String", "Range", "Imu", "Imu"]) == (
        f"{library}Imu\tKEYWORD1\nRange\tKEYWORD1\n"
    )

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.codegen.library_source import client_library
from rostether.codegen.sketch_includes import unresolved_includes
from rostether.errors import ConfigError
from unit.codegen.hostile import write_definitions


def includes(root: Path, sketch: str, files: dict[str, str], search: tuple[str, ...] = ()) -> dict[str, str]:
    """Write files; return what the sketch includes from other folders, with the `file:line` of each."""
    write_definitions(root, files)
    library = root / "library"
    library.mkdir(exist_ok=True)
    found = unresolved_includes(
        root / sketch, library_sources=library, search=[root / each for each in search]
    )
    return {each.path: each.location.removeprefix(f"{root}/") for each in found}


def test_only_real_includes_count(tmp_path: Path) -> None:
    text = """// #include <a/A.h>
/* #include <b/B.h>
#include <c/C.h> */
const char* x = "\\
#include <d/D.h>";
const char* y = "//"; /* " */
#include <e/E.h>  // e
  #  include "f/F.h"
char z = '"';
#include <g/G.h>
auto r = R"x(
#include <h/H.h>
)x";
#include <i/I.h>
"""
    assert includes(tmp_path, "s.ino", {"s.ino": text}) == {
        "e/E.h": "s.ino:7",
        "f/F.h": "s.ino:8",
        "g/G.h": "s.ino:10",
        "i/I.h": "s.ino:14",
    }


def test_own_headers_are_followed_with_their_implementations(tmp_path: Path) -> None:
    files = {
        "main.cpp": '#include "arm/arm.h"\n#include <top.h>\n',
        "arm/arm.h": '#include "joint.h"\n',
        "arm/joint.h": '#include "joint.h"\n#include <a/A.h>\n',
        "arm/arm.cpp": "#include <b/B.h>\n",
        "top.h": "#include <c/C.h>\n",
        "other.cpp": "#include <d/D.h>\n",
    }
    assert includes(tmp_path, "main.cpp", files) == {
        "a/A.h": "arm/joint.h:2",
        "b/B.h": "arm/arm.cpp:1",
        "c/C.h": "top.h:1",
    }


def test_a_sketch_is_its_whole_folder(tmp_path: Path) -> None:
    files = {
        "robot/robot.ino": "#include <a/A.h>\r\n",
        "robot/wheels.ino": "#include <b/B.h>\r\n",
        "robot/src/deep/x.cpp": "\r\n#include <c/C.h>\r\n",
        "robot/.pio/y.cpp": "#include <d/D.h>\n",
        "robot/lib/ros_lib/src/ros.h": "#include <e/E.h>\n",
        "robot/lib/ros_lib/src/ros/node_handle.h": "#include <e/E.h>\n",
        "robot/notes.txt": "#include <f/F.h>\n",
    }
    expected = {
        "a/A.h": "robot/robot.ino:1",
        "b/B.h": "robot/wheels.ino:1",
        "c/C.h": "robot/src/deep/x.cpp:2",
    }
    assert includes(tmp_path, "robot", files) == expected
    assert includes(tmp_path, "robot/robot.ino", {}) == expected
    assert includes(tmp_path, "robot/wheels.ino", {}) == {"b/B.h": "robot/wheels.ino:1"}


def test_further_folders_are_searched(tmp_path: Path) -> None:
    files = {"s.ino": "#include <Robot.h>\n", "libs/Robot/Robot.h": "#include <a/A.h>\n"}
    assert includes(tmp_path, "s.ino", files) == {"Robot.h": "s.ino:1"}
    assert includes(tmp_path, "s.ino", {}, search=("libs/Robot",)) == {"a/A.h": "libs/Robot/Robot.h:1"}


def test_the_library_is_followed(tmp_path: Path) -> None:
    sources = client_library() / "src"
    (tmp_path / "s.ino").write_text("#include <tf/transform_broadcaster.h>\n")
    found = {each.path for each in unresolved_includes(tmp_path / "s.ino", library_sources=sources)}
    assert {"tf/tfMessage.h", "geometry_msgs/TransformStamped.h"} & found


def test_no_sketch(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for sketch, reason in (("nothing.ino", "no sketch at"), ("empty", "has no .ino")):
        with pytest.raises(ConfigError, match=reason):
            includes(tmp_path, sketch, {})


def test_bytes_that_are_not_text_are_ignored(tmp_path: Path) -> None:
    (tmp_path / "s.ino").write_bytes(b"// \xff\xfe\0\n#include <a/A.h>\n#include <\0>\n")
    assert "a/A.h" in includes(tmp_path, "s.ino", {})

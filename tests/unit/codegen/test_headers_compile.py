"""Every generated header compiles without a warning, with all compilers and their platforms' macros."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.codegen.arduino_library import WrittenLibrary
from unit.codegen.compilers import COMPILERS

ALONE = ("hostile/Hostile", "hostile/Types", "hostile/Switch", "sensor_msgs/PointCloud2", "tf/tfMessage")
# Constants by both names, even if their address is needed; fields by the names that sketches use.
USES = """
static_assert(hostile::Hostile::HIGH__ == 1 && hostile::Hostile::DEFAULT_ == 0, "aliases");
static_assert(hostile::Hostile::twice == 2, "the last of two counts");
static_assert(hostile::Hostile::MIN64 + 1 == -9223372036854775807LL, "");
static_assert(hostile::Hostile::MIN64 == -hostile::Hostile::MAX63 - 1, "");
static_assert(hostile::Hostile::MAX64 == 0xffffffffffffffffULL, "");
static_assert(hostile::Hostile::MIN32 == -2147483647L - 1 && hostile::Hostile::MAX32 == 4294967295UL, "");
static_assert(hostile::Hostile::MIN_BYTE == -128 && hostile::Hostile::MAX_CHAR == 255, "");
static_assert(hostile::Hostile::TRUE_ == 1 && hostile::Hostile::NO == 0, "");
static_assert(hostile::Hostile::LOW_ == -1.5f && hostile::Hostile::SMALL == 0, "");
static_assert(hostile::Hostile::SUBNORMAL > 0 && hostile::Hostile::INFINITE_ < -1e30, "");
static_assert(hostile::Hostile::NAN_ != hostile::Hostile::NAN_, "");
static_assert(hostile::SwitchRequest::A == 1 && hostile::Switch::Response::A == 2, "");
static_assert(hostile::Hostile::S[0] == '"' && hostile::Hostile::EMPTY[0] == '\\0', "");
const float& by_reference(bool which) { return which ? hostile::Hostile::LOW_ : hostile::Hostile::F_; }
const char* const* address() { return &hostile::OnlyConstants::NAME; }

hostile::Hostile hostile_message;
with_dash::A dashed;
namespace_::A renamed;
time_::Time in_renamed;
hostile::class_ keyword;
hostile::HIGH_ macro;
sensor_msgs::PointCloud2 cloud;

void use_fields() {
  hostile_message.class_ = hostile_message.HIGH_ = hostile_message.serialize_ = 1;
  hostile_message.min = hostile_message.fields = hostile_message.data = 2;
  hostile_message.new__length = 0;
  hostile_message.seq_length_ = 300;
  cloud.fields_length = 0;
  keyword.ros.ros = 3;
}
"""

COMPILER_NAMES = [pytest.param(name, marks=getattr(pytest.mark, name)) for name in COMPILERS]


@pytest.mark.parametrize("compiler", COMPILER_NAMES)
def test_all_headers_together(compiler: str, hostile_library: WrittenLibrary, tmp_path: Path) -> None:
    assert hostile_library.library.skipped == ()
    includes = [f"#include <{name}.h>" for name in hostile_library.library.types]
    source = tmp_path / "all.cpp"
    source.write_text("\n".join([*includes, USES]))
    reported = COMPILERS[compiler].compile(source, hostile_library.path, tmp_path / "all.o")
    assert not reported


@pytest.mark.parametrize("name", ALONE)
@pytest.mark.parametrize("compiler", [each for each in COMPILER_NAMES if each.values[0] in ("gcc", "avr")])
def test_a_header_alone(compiler: str, name: str, hostile_library: WrittenLibrary, tmp_path: Path) -> None:
    source = tmp_path / "alone.cpp"
    # Twice, to test the guard; a sketch may also have macros with the names of constants.
    source.write_text(f"#define DEBUG 1\n#define ON 2\n#include <{name}.h>\n#include <{name}.h>\n")
    assert not COMPILERS[compiler].compile(source, hostile_library.path)


@pytest.mark.gcc
def test_the_platforms_macros_are_restored(hostile_library: WrittenLibrary, tmp_path: Path) -> None:
    source = tmp_path / "macros.cpp"
    source.write_text(
        "#define HIGH 0x1\n#define INPUT_PULLUP 0x2\n#include <hostile/Hostile.h>\n"
        'static_assert(HIGH == 1 && INPUT_PULLUP == 2, "");\n#ifdef OUTPUT\n#error\n#endif\n'
    )
    assert not COMPILERS["gcc"].compile(source, hostile_library.path)

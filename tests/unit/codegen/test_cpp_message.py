from __future__ import annotations

from rostether.codegen.message_headers import message_header, service_header
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import parse_service
from rostether.msgdef.registry import Registry

RANGE_CLASS = """\
namespace sensor_msgs {

class Range : public ros::Message<Range> {
 public:
  enum { ULTRASOUND = 0 };
  enum { INFRARED = 1 };

  typedef ::std_msgs::Header _header_type;
  _header_type header;
  typedef uint8_t _radiation_type_type;
  _radiation_type_type radiation_type;
  typedef float _field_of_view_type;
  _field_of_view_type field_of_view;
  typedef float _min_range_type;
  _min_range_type min_range;
  typedef float _max_range_type;
  _max_range_type max_range;
  typedef float _range_type;
  _range_type range;

  constexpr Range() : header{}, radiation_type{0}, field_of_view{0}, min_range{0}, max_range{0}, range{0} {}

  template <class Archive, class Self>
  static void _fields(Archive& archive, Self& self) {
    archive.message(self.header);
    archive.value(self.radiation_type);
    archive.value(self.field_of_view);
    archive.value(self.min_range);
    archive.value(self.max_range);
    archive.value(self.range);
  }

  ROS_MESSAGE_TYPE("sensor_msgs/Range", "c005c34273dc426c67a020a87bc24148")
};

}  // namespace sensor_msgs
"""


def generated(text: str) -> str:
    return message_header(parse_message(text, package="pkg", name="Foo"), "0" * 32)


def test_a_message() -> None:
    registry = Registry()
    name = "sensor_msgs/Range"
    text = message_header(registry.message(name), registry.message_type(name).md5sum)
    assert RANGE_CLASS in text
    assert '\n#include "ros/message.h"\n#include "std_msgs/Header.h"\n' in text
    assert text.count("ROS_sensor_msgs_Range_H_") == 2
    assert all(line == line.rstrip() for line in text.splitlines())


def test_arrays() -> None:
    text = generated(
        "uint8[] a\nstring[] b\nfloat64[] c\nint64[] d\nstring[3] e\nuint64[2] f\ntime[] g\nX[] h"
    )
    for lines in (
        "  ros::array_length a_length;\n  typedef uint8_t _a_type;\n  _a_type* a;\n",
        "  typedef char* _b_type;\n  _b_type* b;\n",
        "  ros::array_length c_length;\n  typedef double _c_type;\n  ros::Float64Pointer c;\n",
        "  typedef ros::unaligned_int64 _d_type;\n  _d_type* d;\n",
        "  char* e[3];\n  uint64_t f[2];\n",
        "  typedef ros::Time _g_type;\n  _g_type* g;\n",
        "  typedef ::pkg::X _h_type;\n  _h_type* h;\n",
        "    archive.sequence(self.a, self.a_length);\n    archive.sequence(self.b, self.b_length);\n",
        "    archive.sequence64(self.d, self.d_length);\n    archive.fixed(self.e);\n",
    ):
        assert lines in text
    assert "a_length{0}, a{nullptr}" in text.replace("\n      , ", ", ")
    assert '#include "pkg/X.h"\n' in text


def test_an_array_without_elements_is_not_a_member() -> None:
    text = generated("float32[0] none\nuint8 x")
    assert "// none has no elements.\n" in text
    assert "none{" not in text and "self.none" not in text


def test_an_empty_message_has_no_unused_parameters() -> None:
    text = generated("")
    assert "  constexpr Foo() {}\n" in text
    assert "  static void _fields(Archive&, Self&) {}\n" in text


def test_float_and_string_constants_are_in_a_class_template() -> None:
    text = generated("float32 A=1.5\nfloat64 B=1e300\nstring C=x\nuint8 D=1\nuint8 field")
    assert "class Foo : public ros::Message<Foo>, public _constants_of_Foo<void> {\n" in text
    assert "  static constexpr float A = 1.5f;\n" in text
    b = "  static constexpr double B = {};\n"
    assert f"< 8\n{b.format('__builtin_inff()')}#else\n{b.format('1e+300')}#endif\n" in text
    assert '  static constexpr const char* C = "x";\n' in text
    assert "template <class T>\nconstexpr const char* _constants_of_Foo<T>::C;\n" in text
    assert "  enum { D = 1 };\n" in text


def test_constants_are_protected_from_macros() -> None:
    text = generated("uint8 HIGH=1\nuint8 OTHER=2\nuint8 near\nuint8 far_away")
    before, inside, after = text.partition("namespace pkg {")[0], text, text.partition("}  // namespace")[2]
    for name in ("HIGH", "OTHER", "near"):
        assert f'#pragma push_macro("{name}")\n#undef {name}\n' in before
        assert f'#pragma pop_macro("{name}")\n' in after
    assert "far_away" not in before
    assert "  enum { HIGH = 1 };\n  enum { HIGH_ = HIGH };\n" in inside


def test_request_and_response_have_their_own_md5sums() -> None:
    spec = parse_service("bool data\n---\nbool success\n", package="std_srvs", name="Set")
    text = service_header(spec, "a" * 32, "b" * 32)
    assert "class SetRequest : public ros::Message<SetRequest> {" in text
    assert f'ROS_MESSAGE_TYPE("std_srvs/Set", "{"a" * 32}")' in text
    assert f'ROS_MESSAGE_TYPE("std_srvs/Set", "{"b" * 32}")' in text
    assert (
        "class Set {\n public:\n  typedef SetRequest Request;\n  typedef SetResponse Response;\n};\n" in text
    )

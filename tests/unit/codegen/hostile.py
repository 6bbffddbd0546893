"""Difficult definitions for a generator: names, constants and types that C++ or a platform uses."""

from __future__ import annotations

from pathlib import Path

CONSTANTS = r"""
int32 HIGH=1
int32 INPUT=0
uint8 B1=1
uint8 DEFAULT=0
uint8 EXTERNAL=1
uint8 DISPLAY=2
uint8 ERROR=4
uint8 DELETE=5
uint8 NO_ERROR=0
uint8 DEBUG=1
uint8 class=7
uint8 _x_type=1
uint8 x=2
uint8 Hostile=9
uint8 twice=1
uint8 twice=2
int64 MIN64=-9223372036854775808
int64 MAX63=9223372036854775807
uint64 MAX64=18446744073709551615
int32 MIN32=-2147483648
uint32 MAX32=4294967295
int16 MIN16=-32768
byte MIN_BYTE=-128
char MAX_CHAR=255
bool TRUE=True
bool NO=0
float64 X=1e300
float64 TINY=-1e-300
float64 SUBNORMAL=1e-40
float64 INFINITE=-inf
float64 NAN=nan
float64 PI=3.141592653589793
float32 F=0.1
float32 HUGE=1e300
float32 SMALL=1e-300
float32 LOW=-1.5
string S= "quoted \ # text
string OUTPUT=what??/ is	this é
string EMPTY=
"""

FIELDS = """
uint8 x
uint8 class
uint8 HIGH
uint8 B1
uint8 data
uint8 serialize
uint8 deserialize
uint8 fields
uint8 Archive
uint8 Self
uint8 archive
uint8 self
uint8 Hostile
uint8 ros
uint8 std_msgs
uint8 hostile
Header Header
std_msgs/Header Time
uint8 uint8_t
uint8 min
uint8 max
uint8 round
uint8 F
uint8 near
uint8 linux
uint8 errno
uint8 size_t
uint8 Message
uint8 M
uint8 string
uint8 array_length
uint8[] seq
uint16 seq_length
uint8[] new
uint8[] new_
uint16 new__length
uint8 getType
float32[0] nothing
"""

TYPES = """
string text
string[3] names
string[] more
bool yes
bool[2] switches
bool[] flags
byte signed
char letter
char[] letters
byte[4] four
uint8[] blob
uint8[5] bytes
int16[] shorts
uint32[3] words
int64 long_one
uint64[2] two
int64[] longs
uint64[] unsigned_longs
float32[] floats
float64 double_one
float64[3] three
float64[] doubles
time stamp
time[] stamps
time[2] two_stamps
duration span
duration[] spans
std_msgs/Header header
std_msgs/Header[] headers
Nested nested
Nested[2] pair
Nested[] nested_ones
Empty nothing
Empty[3] nothings
Nested[] last
"""

DEFINITIONS = {
    "hostile/msg/Hostile.msg": CONSTANTS + FIELDS,
    "hostile/msg/Types.msg": TYPES,
    "hostile/msg/Nested.msg": "string[] texts\nstd_msgs/Header[] headers\nstring s\nint64[] n\nuint8 end\n",
    "hostile/msg/Empty.msg": "",
    "hostile/msg/OnlyConstants.msg": "string NAME=only\nuint8 ONE=1\n",
    "hostile/msg/class.msg": "uint8 class\nhostile/ros ros\n",
    "hostile/msg/ros.msg": "uint8 ros\n",
    "hostile/msg/std_msgs.msg": "uint8 data\n",
    "hostile/msg/HIGH.msg": "uint8 HIGH\nuint8 HIGH_\nuint8 HIGH=3\n",
    "hostile/msg/Clash.msg": "std_msgs/String a\nhostile/std_msgs b\nhostile/HIGH h\n",
    "hostile/srv/Switch.srv": "float32 A=1\nint32 ON=1\nstring[] names\n---\nfloat32 A=2\nstring message\n",
    "hostile/srv/Nothing.srv": "---\n",
    "unix/msg/A.msg": "uint8 a\n",
    "namespace/msg/A.msg": "unix/A a\n",
    "time/msg/Time.msg": "namespace/A a\ntime stamp\n",
    "with-dash/msg/A.msg": "time/Time[] times\n",
    "with-dash/msg/B.msg": "A a\nhostile/SwitchRequest[] asked\n",
    "a_b/msg/C.msg": "uint8 data\n",
    "a/msg/b_C.msg": "a_b/C c\n",
}


def write_definitions(root: Path, definitions: dict[str, str] = DEFINITIONS) -> Path:
    """Write definitions below a folder and return it."""
    for path, text in definitions.items():
        file = root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return root

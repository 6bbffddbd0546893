"""md5sums and full texts equal those of Debian's genmsg, for every installed type and for unusual texts."""

from __future__ import annotations

import functools
import json
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.parse_srv import expand_action
from rostether.msgdef.registry import Registry

pytestmark = pytest.mark.ros1

DEBIAN_PYTHON = "/usr/bin/python3"
DEBIAN_SHARE = Path("/usr/share")

GENMSG_REFERENCE = """
import json, os, sys
import genmsg.msg_loader as loader
from genmsg import gentools

request = json.load(sys.stdin)
search_path = request["search_path"]
answer = {"messages": {}, "services": {}}

def describe(context, spec):
    loader.load_depends(context, spec, search_path)
    return {
        "md5sum": gentools.compute_md5(context, spec),
        "definition": gentools.compute_full_text(context, spec),
        "fields": [[f.base_type, f.name, f.is_array, f.array_len] for f in spec.parsed_fields()],
        "constants": [[c.type, c.name, c.val, c.val_text] for c in spec.constants],
    }

for package, folders in search_path.items():
    for folder in folders:
        for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if file.endswith(".msg"):
                context = loader.MsgContext.create_default()
                name = package + "/" + file[:-4]
                try:
                    spec = loader.load_msg_by_type(context, name, search_path)
                    answer["messages"][name] = describe(context, spec)
                except Exception as error:
                    answer["messages"][name] = {"error": repr(error)}
for package, folders in request["service_path"].items():
    for folder in folders:
        for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if file.endswith(".srv"):
                context = loader.MsgContext.create_default()
                name = package + "/" + file[:-4]
                spec = loader.load_srv_by_type(context, name, request["service_path"])
                answer["services"][name] = {
                    "request": describe(context, spec.request),
                    "response": describe(context, spec.response),
                    "md5sum": gentools.compute_md5(context, spec),
                }
json.dump(answer, sys.stdout)
"""

UNUSUAL_TEXTS = {
    "Empty": "",
    "OnlyComment": "# nothing here",
    "NoFinalNewline": "int32 x",
    "CommentsAfterFields": "int32 x # meters = 3\n  float32   y#tight\n#int8 z\n",
    "CarriageReturns": "int32 x\r\nstring NAME=text\r\nfloat64[3] y\r\n",
    "OldMacReturns": "int32 x\rint32 y\r",
    "Integers": "\n".join(
        [
            "int8 A=-128\nuint8 B=255\nint16 C=-32768\nuint16 D=65535\nint32 E=-2147483648",
            "uint32 F=4294967295",
            "int64 G=-9223372036854775808\nuint64 H=18446744073709551615\nbyte I=-128\nchar J=255",
            "int32 K=05\nint32 L=+7\nint32 M = -0\nint32 N=  12   # twelve\nint32 O=1_000",
        ]
    ),
    "Floats": "float32 A=1e-3\nfloat64 B=.5\nfloat32 C=-1.\nfloat64 D = 1E+20 # big\n"
    "float32 E=nan\nfloat64 F=-inf\nfloat32 G=3",
    "Bools": "bool A=True\nbool B=False\nbool C=1\nbool D=0\nbool E=05\n",
    "BoolsAgain": "bool A=2\nbool B='x'\nbool C=0.0\nbool D=[]\n",
    "BoolLower": "bool A=true",
    "Strings": """string A=\nstring B=   \nstring C=  padded text  \nstring D="quoted" # kept
string E=a=b=c\nstring F=#\nstring G='x'""",
    "StringLast": "int32 x\nstring A=",
    "StringUnicode": "string A=\u00e9t\u00e9 \u2603\nint32 x # \u00b5m",
    "StringSpacedName": "string   A  =x",
    "StringTabs": "string A=\tx\ty\t",
    "NonBreakingBlank": "string A=x\u00a0",
    "ConstantsBetweenFields": "int32 a\nint32 A=1\nint32 b\nint32 B=2\nHeader header\n",
    "ConstantTwice": "int32 A=1\nint32 A=2\n",
    "ConstantUnderscore": "int32 _A=1\n",
    "HexConstant": "int32 A=0x10",
    "FloatForInteger": "int32 A=1.0",
    "EmptyInteger": "int32 A=\n",
    "TooLarge": "uint8 A=256",
    "TooSmall": "char A=-1",
    "TwoEquals": "int32 A=1=2",
    "TimeConstant": "time A=1",
    "MessageConstant": "Header A=1",
    "Primitives": "bool a\nint8 b\nuint8 c\nint16 d\nuint16 e\nint32 f\nuint32 g\nint64 h\nuint64 i\n"
    "float32 j\nfloat64 k\nstring l\ntime m\nduration n\nbyte o\nchar p\n",
    "Arrays": "int8[] a\nuint8[4] b\nstring[] c\nstring[2] d\ntime[] e\nduration[3] f\n"
    "bool[0] g\nint32[05] h\n",
    "ArrayTwice": "int8[][] a",
    "ArrayNegative": "int8[-1] a",
    "ArrayBlank": "int8[ 3 ] a",
    "ArrayOpen": "int8[3 a",
    "ArrayWord": "int8[n] a",
    "Header": "Header header\nHeader second\n",
    "HeaderFull": "std_msgs/Header header\n",
    "HeaderLater": "int32 x\nHeader h\n",
    "HeaderArray": "Header[] headers\n",
    "Nested": "Primitives p\nArrays[] many\nodd/Header own\nArrays[2] two\nArrays again\n",
    "NestedOther": "geometry_msgs/PoseStamped pose\nNested n\nsensor_msgs/Imu[] imus\n",
    "NestedDiamond": "geometry_msgs/Pose a\ngeometry_msgs/Point b\ngeometry_msgs/PoseArray c\n"
    "std_msgs/Header d\n",
    "UnknownType": "Missing m\n",
    "UnknownPackage": "missing_msgs/Missing m\n",
    "DuplicateField": "int32 a\nfloat32 a\n",
    "BadFieldName": "int32 1a\n",
    "UnderscoreField": "int32 _a\n",
    "TrailingUnderscore": "int32 a_\nint32 lambda\nint32 class\nint32 self\n",
    "ThreeWords": "int32 a b\n",
    "OneWord": "int32\n",
    "BadType": "int-32 a\n",
    "DeepName": "a/b/c d\n",
    "SlashEnd": "std_msgs/ a\n",
    "ManyBlanks": "   int32     a   \n\n\n   \n float32   b # c\n",
    "TabIndented": "\tint32 a\n\tint32 A=1\n",
    "DashedLines": "---\nint32 a\n",
    "FormFeed": "int32 a\x0c\nint32 b\n",
}
# genmsg refuses the first, and names the constant of the second 'string S'; to read them as intended is
# harmless.
READ_ONLY_BY_ROSTETHER = {
    "TabSeparated": "int32\ta\nint32\tA=1\nstring\tS=x\n",
    "IndentedString": "int32 a\n  string S=x\n",
}
# genmsg reads these, but its names do not compile in any language.
READ_ONLY_BY_GENMSG = {
    "ConstantNameBlank": "int32 A B=1\n",
    "ConstantNameless": "int32 =1\n",
    "FieldNameUnicode": "int32 gr\u00f6\u00dfe\n",
}


@functools.cache
def genmsg_answer(search_path: str, service_path: str) -> Any:
    """Ask genmsg, in one process, for everything in the given folders (JSON in, parsed JSON out)."""
    request = f'{{"search_path": {search_path}, "service_path": {service_path}}}'
    completed = subprocess.run(
        [DEBIAN_PYTHON, "-c", GENMSG_REFERENCE], input=request.encode(), capture_output=True, timeout=120
    )
    assert completed.returncode == 0, completed.stderr.decode()
    return json.loads(completed.stdout)


def debian_folders(kind: str) -> dict[str, list[str]]:
    return {folder.parent.name: [str(folder)] for folder in sorted(DEBIAN_SHARE.glob(f"*/{kind}"))}


def debian_answer() -> Any:
    return genmsg_answer(json.dumps(debian_folders("msg")), json.dumps(debian_folders("srv")))


def debian_registry() -> Registry:
    roots = [folder.parent for kind in ("msg", "srv") for folder in sorted(DEBIAN_SHARE.glob(f"*/{kind}"))]
    return Registry(roots, bundled=False)


def as_genmsg(registry: Registry, name: str) -> dict[str, Any]:
    """Describe a message of rostether in the form of the reference."""
    spec, message_type = registry.message(name), registry.message_type(name)
    return {
        "md5sum": message_type.md5sum,
        "definition": message_type.definition,
        "fields": [[f.type.base, f.name, f.type.is_array, f.type.length] for f in spec.fields],
        "constants": [[c.type, c.name, c.value, c.text] for c in spec.constants],
    }


def normalized(value: Any) -> str:
    """Return a text that is the same for equal answers; as a text, NaN equals NaN."""
    return json.dumps(value, sort_keys=True)


def test_every_debian_message_has_genmsgs_md5sum_and_full_text() -> None:
    messages = debian_answer()["messages"]
    assert len(messages) > 100
    registry = debian_registry()
    for name, expected in messages.items():
        assert normalized(as_genmsg(registry, name)) == normalized(expected), name


def test_every_debian_service_has_genmsgs_md5sums_and_full_texts() -> None:
    services = debian_answer()["services"]
    assert len(services) > 20
    registry = debian_registry()
    for name, expected in services.items():
        service_type = registry.service_type(name)
        assert service_type.md5sum == expected["md5sum"], name
        for part in ("request", "response"):
            described = as_genmsg(registry, getattr(service_type, part).name)
            assert normalized(described) == normalized(expected[part]), name


def test_bundled_definitions_have_debians_md5sums() -> None:
    answer, bundled = debian_answer(), Registry()
    debian_packages = {name.partition("/")[0] for name in (*answer["messages"], *answer["services"])}
    both = debian_packages.intersection(bundled.packages())
    assert {"std_msgs", "sensor_msgs", "tf2_msgs", "visualization_msgs"} <= both
    for name, expected in answer["messages"].items():
        if name.partition("/")[0] in both:
            spec = bundled.message(name)
            assert bundled.message_type(name).md5sum == expected["md5sum"], name
            assert normalized([[c.type, c.name, c.value, c.text] for c in spec.constants]) == normalized(
                expected["constants"]
            ), name
    for name, expected in answer["services"].items():
        if name.partition("/")[0] in both:
            assert bundled.service_type(name).md5sum == expected["md5sum"], name
    # Each bundled type of these packages also exists in Debian.
    assert {n for n in bundled.messages() if n.partition("/")[0] in both} <= set(answer["messages"])
    assert {n for n in bundled.services() if n.partition("/")[0] in both} <= set(answer["services"])


def test_bundled_roscpp_types_are_those_of_debians_rospy() -> None:
    program = (
        "import json, roscpp.msg, roscpp.srv; print(json.dumps({c._type: c._md5sum for c in ("
        "roscpp.msg.Logger, roscpp.srv.Empty, roscpp.srv.GetLoggers, roscpp.srv.SetLoggerLevel)}))"
    )
    completed = subprocess.run([DEBIAN_PYTHON, "-c", program], capture_output=True, timeout=120)
    assert completed.returncode == 0, completed.stderr.decode()
    expected = json.loads(completed.stdout)
    bundled = Registry()
    assert bundled.message_type("roscpp/Logger").md5sum == expected.pop("roscpp/Logger")
    assert {name: bundled.service_type(name).md5sum for name in expected} == expected


def test_action_messages_are_those_that_debian_generated() -> None:
    actions = sorted(DEBIAN_SHARE.glob("*/action/*.action"))
    assert {action.parent.parent.name for action in actions} >= {"nav_msgs", "tf2_msgs"}
    registry = Registry({action.parent.parent for action in actions})
    for action in actions:
        for name, text in expand_action(action.read_text(), name=action.stem).items():
            generated = action.parent.parent / "msg" / f"{name}.msg"
            assert text == generated.read_text(), generated
            assert registry.message(f"{action.parent.parent.name}/{name}").text == text


def write_texts(folder: Path, texts: dict[str, str]) -> str:
    messages = folder / "odd" / "msg"
    messages.mkdir(parents=True)
    for name, text in texts.items():
        (messages / f"{name}.msg").write_bytes(text.encode())
    return str(messages)


def compare_texts(folder: Path, texts: dict[str, str]) -> tuple[list[str], int]:
    """Return the differences from genmsg, and the number of texts that both read."""
    search_path = {**debian_folders("msg"), "odd": [write_texts(folder, texts)]}
    expected = genmsg_answer(json.dumps(search_path), "{}")["messages"]
    registry = Registry([folder])
    differences: list[str] = []
    read = 0
    for short_name, text in texts.items():
        genmsg = expected[f"odd/{short_name}"]
        try:
            rostether = as_genmsg(registry, f"odd/{short_name}")
        except DefinitionError as error:
            rostether = {"error": str(error)}
        if "error" in genmsg and "error" in rostether:
            assert "\n" not in rostether["error"]
            continue
        read += 1
        # Bundled dependencies have no comments; the unusual texts are compared completely.
        if "definition" in genmsg and "definition" in rostether:
            genmsg["definition"], rostether["definition"] = (
                comparable_definition(genmsg),
                comparable_definition(rostether),
            )
        if normalized(genmsg) != normalized(rostether):
            differences.append(f"{short_name} {text!r}:\n  genmsg {genmsg}\n  rostether {rostether}")
    return differences, read


def comparable_definition(described: dict[str, Any]) -> list[str]:
    parts = described["definition"].split("=" * 80 + "\n")
    return [parts[0]] + [part.partition("\n")[0] if "odd/" not in part else part for part in parts[1:]]


def test_unusual_texts_are_read_or_refused_as_by_genmsg(tmp_path: Path) -> None:
    differences, read = compare_texts(tmp_path, UNUSUAL_TEXTS)
    assert not differences, "\n".join(differences)
    assert read > 25


def test_texts_that_only_one_of_both_reads(tmp_path: Path) -> None:
    differences, _ = compare_texts(tmp_path, {**READ_ONLY_BY_ROSTETHER, **READ_ONLY_BY_GENMSG})
    assert len(differences) == len(READ_ONLY_BY_ROSTETHER) + len(READ_ONLY_BY_GENMSG), "\n".join(differences)
    registry = Registry([tmp_path])
    for name in READ_ONLY_BY_ROSTETHER:
        spec = registry.message(f"odd/{name}")
        assert [field.name for field in spec.fields] == ["a"]
        assert ("S", "x") in [(constant.name, constant.value) for constant in spec.constants]
    for name in READ_ONLY_BY_GENMSG:
        with pytest.raises(DefinitionError):
            registry.message(f"odd/{name}")


def random_line(rng: random.Random) -> str:
    types = ["int8", "uint64", "float32", "string", "bool", "time", "char", "Header", "Nope", "std_msgs/Time"]
    values = ["1", "-5", "05", "1e-3", " 7 ", "", "True", "text # more", '"a"', "x=y", "300", "=", "#", "0x1"]
    names = ["a", "b", "c", "D", "E_2", "f1", "g_"]
    arrays = ["", "", "", "[]", "[3]", "[0]", "["]
    line = rng.choice(types) + rng.choice(arrays) + rng.choice([" ", "  "])
    line += rng.choice(names)
    if rng.random() < 0.4:
        line += rng.choice(["=", " = ", "= "]) + rng.choice(values)
    return line + rng.choice(["", "", " ", "  # note", "# x=1", "\r"])


def test_random_texts_are_read_or_refused_as_by_genmsg(tmp_path: Path) -> None:
    rng = random.Random(20)
    texts = {
        f"Random{number}": "\n".join(random_line(rng) for _ in range(rng.choice([1, 1, 1, 2, 3])))
        for number in range(600)
    }
    differences, read = compare_texts(tmp_path, texts)
    assert not differences, "\n".join(differences)
    assert read > 60

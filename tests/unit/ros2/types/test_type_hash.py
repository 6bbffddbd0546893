"""RIHS01 hashes, compared with those that rosidl wrote, and with published ones."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.parse import parse_message
from rostether.ros2.types.type_hash import event_message, message_hash, rihs01, service_hash

# The folder in which the rosidl wheels have the sources of their types.
INSTALLED = Path(sys.prefix)
PUBLISHED = {
    "std_msgs/msg/String": "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "builtin_interfaces/msg/Time": "RIHS01_b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
    "service_msgs/msg/ServiceEventInfo": (
        "RIHS01_41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45"
    ),
    "std_srvs/srv/SetBool": "RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    "std_srvs/srv/SetBool_Request": "RIHS01_c62fbb99d94e1b25e8ef9e109f9581956bb1b3361a45a4e5810c36a90d29932e",
    "std_srvs/srv/SetBool_Response": (
        "RIHS01_d0814e7f7b4880ab77e9c57426c7aa1562ab69f11eef8e2e968812f9cbd0b059"
    ),
    "example_interfaces/action/Fibonacci_SendGoal": (
        "RIHS01_d1a57fb2a4afe8c21e34fb10db206f16ce6729b28531141472df92277c55b557"
    ),
    "example_interfaces/action/Fibonacci_GetResult": (
        "RIHS01_1b0de0d5d29dc955d92f546706568428632771db13ec84c15ec1c1a59f424a57"
    ),
    "example_interfaces/action/Fibonacci_FeedbackMessage": (
        "RIHS01_c1de71afd52e49a89c53d8262366884185bc0a02f78ce051c4e46b0a7fe59bb2"
    ),
}


def hash_of(name: str, definitions: Ros2Definitions) -> str:
    if name.endswith("_Event"):
        return rihs01(event_message(definitions.service(name.removesuffix("_Event"))), definitions.message)
    if name.endswith(("_SendGoal", "_GetResult")):
        return service_hash(definitions.service(name), definitions)
    if "/srv/" in name and not name.endswith(("_Request", "_Response")):
        return service_hash(definitions.service(name), definitions)
    return message_hash(definitions.message(name), definitions)


@pytest.mark.parametrize("name", PUBLISHED)
def test_hashes_are_the_published_ones(name: str) -> None:
    assert hash_of(name, Ros2Definitions()) == PUBLISHED[name]


@pytest.mark.parametrize("installed", [True, False], ids=["installed", "bundled"])
def test_hashes_are_those_of_every_installed_type(installed: bool) -> None:
    files = sorted((INSTALLED / "share").glob("*/*/*.json"))
    definitions = Ros2Definitions(prefixes=[INSTALLED], bundled=False) if installed else Ros2Definitions()
    checked = 0
    for file in files:
        for entry in json.loads(file.read_text()).get("type_hashes", ()):
            name = entry["type_name"]
            if not installed and name.partition("/")[0] not in definitions.packages():
                continue
            if name.startswith("test_msgs/"):
                # Some of its types are .idl files, which are not read; actions are not on the graph as such.
                continue
            assert hash_of(name, definitions) == entry["hash_string"], name
            checked += 1
    if not checked:
        pytest.skip("the rosidl packages are not installed here")
    assert checked > 500


def test_humble_has_no_hashes() -> None:
    definitions = Ros2Definitions(distro="humble")
    assert hash_of("std_msgs/msg/String", definitions) == "TypeHashNotSupported"
    assert hash_of("std_srvs/srv/SetBool", definitions) == "TypeHashNotSupported"


def test_only_names_and_types_change_the_hash() -> None:
    definitions = Ros2Definitions()

    def hashed(text: str) -> str:
        return rihs01(parse_message(text, package="x", name="Foo"), definitions.message)

    plain = hashed("int8 a\n")
    assert hashed("# a comment\nint8 B=1\nint8 a 3\n") == plain
    assert hashed("char a\n") == hashed("uint8 a\n")
    texts = ["int8 b", "uint8 a", "byte a", "int8[] a", "int8[2] a", "int8[<=2] a", "int8[<=3] a"]
    texts += ["string a", "string<=2 a", "string<=3 a", "string<=3[] a", "wstring a", "wstring<=3 a"]
    assert len({plain, *map(hashed, texts)}) == len(texts) + 1

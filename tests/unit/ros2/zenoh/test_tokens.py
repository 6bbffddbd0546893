from __future__ import annotations

import pytest

from rostether.ros2.zenoh.qos import DEFAULT_QOS, LATCHED_QOS, Durability, History, Qos, Reliability
from rostether.ros2.zenoh.tokens import (
    MAX_TOKEN_CHARACTERS,
    Token,
    TokenKind,
    all_tokens,
    data_key,
    format_qos,
    parse_qos,
    parse_token,
)

SESSION = "aac3178e146ba6f1fc6e6a4085e77f21"
HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
NODE = f"@ros2_lv/2/{SESSION}/0/0/NN/%/%robot%arm/listener"
PUBLISHER = (
    f"@ros2_lv/2/{SESSION}/0/10/MP/%/%/talker/%chat%raw/std_msgs::msg::dds_::String_/{HASH}/:1:,1:,:,:,,"
)


def test_a_nodes_token() -> None:
    token = Token(2, SESSION, 0, 0, TokenKind.NODE, "/robot/arm", "listener")
    assert token.format() == NODE
    assert parse_token(NODE) == token
    assert token.node_name == "/robot/arm/listener"


def test_a_publishers_token() -> None:
    token = Token(
        2,
        SESSION,
        0,
        10,
        TokenKind.PUBLISHER,
        "/",
        "talker",
        "/chat/raw",
        "std_msgs::msg::dds_::String_",
        HASH,
        LATCHED_QOS,
    )
    assert token.format() == PUBLISHER
    assert parse_token(PUBLISHER) == token
    assert token.node_name == "/talker"


def test_parts_of_newer_distributions_are_ignored() -> None:
    assert parse_token(f"{PUBLISHER}/cpp%shm") == parse_token(PUBLISHER)


def test_an_enclave_is_kept() -> None:
    text = NODE.replace("/NN/%/", "/NN/%lab/")
    token = parse_token(text)
    assert token is not None
    assert token.enclave == "/lab"
    assert token.format() == text


@pytest.mark.parametrize(
    "text",
    [
        "",
        "@ros2_lv/2",
        NODE.replace("@ros2_lv", "@other"),
        NODE.replace("NN", "XX"),
        NODE.replace("@ros2_lv/2", "@ros2_lv/two"),
        NODE.replace("@ros2_lv/2", "@ros2_lv/²"),
        NODE.replace("@ros2_lv/2", "@ros2_lv/" + "9" * 500),
        NODE.replace("/NN/", "/MP/"),
        PUBLISHER.rpartition("/")[0],
        NODE + "x" * MAX_TOKEN_CHARACTERS,
    ],
)
def test_invalid_tokens_are_none(text: str) -> None:
    assert parse_token(text) is None


def test_data_keys() -> None:
    assert data_key(7, "/chat/raw", "std_msgs::msg::dds_::String_", HASH) == (
        f"7/chat/raw/std_msgs::msg::dds_::String_/{HASH}"
    )
    assert all_tokens(7) == "@ros2_lv/7/**"


TEXTS = [
    (DEFAULT_QOS, "::,10:,:,:,,"),
    (Qos(Reliability.BEST_EFFORT, depth=5), "2::,5:,:,:,,"),
    (LATCHED_QOS, ":1:,1:,:,:,,"),
    (Qos(depth=42), "::,:,:,:,,"),
    (Qos(history=History.KEEP_ALL, depth=0), "::2,0:,:,:,,"),
]


@pytest.mark.parametrize(("qos", "text"), TEXTS)
def test_defaults_are_empty(qos: Qos, text: str) -> None:
    assert format_qos(qos) == text
    assert parse_qos(text) == qos


@pytest.mark.parametrize(
    ("text", "qos"),
    [
        ("", Qos(depth=42)),
        ("1:2:1,7:1,5:2,0:1,9,9", Qos(depth=7)),
        ("0:0:0,0", Qos(depth=0)),
        (
            "2:1:2,:,:,:,,:more",
            Qos(Reliability.BEST_EFFORT, Durability.TRANSIENT_LOCAL, History.KEEP_ALL, 42),
        ),
        ("x:y:z,w", Qos(depth=42)),
        ("::,²:", Qos(depth=42)),
        ("::,-3:", Qos(depth=42)),
    ],
)
def test_every_text_of_a_peer_is_read(text: str, qos: Qos) -> None:
    assert parse_qos(text) == qos


def test_a_depth_of_any_length_is_read() -> None:
    assert parse_qos(f"1:1:1,{'9' * 5000}").depth == Qos(depth=42).depth


def test_only_transient_local_is_latching() -> None:
    assert LATCHED_QOS.is_latching
    assert not DEFAULT_QOS.is_latching

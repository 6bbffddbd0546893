from __future__ import annotations

import gc
import json
import tracemalloc
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import pytest

from loop_watch import CallbackWatch
from rostether.errors import RemoteProtocolError
from rostether.gateways.client_json import MAX_CONTAINERS, parse_in_steps
from rostether.gateways.rosbridge.request import MAX_WORD_CHARACTERS, Request, read_request


def request(**fields: Any) -> Request:
    return Request({"op": "publish", **fields})


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ("garbage", "this is not JSON"),
        ("", "this is not JSON"),
        (b"\xff\xfe\x00", "this is not JSON"),
        ("[1, 2]", r"a message must be a JSON object with an op, got \[1, 2\]"),
        ("7", "a message must be a JSON object"),
        ("{}", "field 'op' must be a string, got nothing"),
        ('{"op": 7}', "field 'op' must be a string, got 7"),
        ('{"op": null}', "field 'op' must be a string, got null"),
        ("[" * 100_000, "nested too deeply"),
        ('{"op": ' + "9" * 5000 + "}", "this is not JSON"),
        ('{"op": [' + "9, " * 70_000 + "9" * 65 + "]}", "more than 64 digits"),
        ('{"op": [' + ("9" * 64 + ", ") * 4096 + "9" * 65 + "]}", "more than 64 digits"),
    ],
)
async def test_what_is_not_a_message_is_refused_in_one_short_line(data: str | bytes, reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=reason) as caught:
        await read_request(data)
    assert len(str(caught.value)) < 250
    assert "\n" not in str(caught.value)


async def test_binary_frames_may_hold_json() -> None:
    assert (await read_request(b'{"op": "publish"}')).op == "publish"


@pytest.mark.parametrize("given", [7, None, ["a"], {}, True])
def test_a_text_must_be_one(given: object) -> None:
    with pytest.raises(RemoteProtocolError, match="publish: field 'topic' must be a string"):
        request(topic=given).text("topic")
    with pytest.raises(RemoteProtocolError, match="got nothing"):
        request().text("topic")


@pytest.mark.parametrize(("given", "read"), [(100, 100.0), ("100", 100.0), (0.5, 0.5), (None, 7.0)])
def test_numbers_may_come_as_texts(given: object, read: float) -> None:
    assert request(throttle_rate=given).number("throttle_rate", 7) == read


@pytest.mark.parametrize("given", [-1, "fast", [], float("nan"), float("inf"), 10**400, "1e999"])
def test_numbers_are_finite_and_not_negative(given: object) -> None:
    with pytest.raises(RemoteProtocolError, match="throttle_rate"):
        request(throttle_rate=given).number("throttle_rate", 0)


@pytest.mark.parametrize(("given", "read"), [(True, True), (False, False), (None, False), (1, True)])
def test_flags(given: object, read: bool) -> None:
    assert request(latch=given).flag("latch") is read


def test_a_flag_is_not_text() -> None:
    with pytest.raises(RemoteProtocolError, match="latch"):
        request(latch="yes").flag("latch")


@pytest.mark.parametrize(
    ("given", "read"),
    [("a:1", "a:1"), (7, 7), ({"x": 1}, None), ([], None), (None, None), (1.5, 1.5), (float("nan"), None)],
)
def test_an_id_is_a_text_or_a_number(given: object, read: object) -> None:
    assert request(id=given).id == read


def test_names_that_are_stored_are_limited() -> None:
    book = "x" * (MAX_WORD_CHARACTERS + 1)
    assert request(id=book[1:], topic=book[1:]).word("topic") == request(id=book[1:]).id
    with pytest.raises(
        RemoteProtocolError, match="'topic' must be at most 512 characters, got \"xxx"
    ) as caught:
        request(topic=book).word("topic")
    assert len(str(caught.value)) < 250
    with pytest.raises(RemoteProtocolError, match="'id' must be at most 512"):
        _ = request(id=book).id
    with pytest.raises(RemoteProtocolError, match="field 'op' must be at most 512"):
        Request({"op": book})


@pytest.mark.parametrize(
    "value", [[[1] * 500_000], {"a": {str(each): 1 for each in range(200_000)}}, [["x" * 5_000_000] * 50]]
)
def test_only_the_beginning_of_what_is_wrong_is_put_into_words(value: object) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(RemoteProtocolError, match="field 'topic' must be a string") as caught:
            request(topic=value).text("topic")
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()
    assert len(str(caught.value)) < 250


def test_what_nests_deeply_is_shown_too() -> None:
    deep: list[object] = []
    for _ in range(100_000):
        deep = [deep]
    with pytest.raises(RemoteProtocolError, match=r"got \[\[\[\[\.\.\.\]\]\]\]"):
        request(topic=deep).text("topic")
    # The nested value is freed here step by step, because Python would free it recursively.
    while deep:
        deep = deep.pop()  # type: ignore[assignment]


@pytest.mark.parametrize("end", ["]}", ""])
async def test_no_garbage_collection_while_a_large_message_is_read(end: str) -> None:
    looked = []

    def look(phase: str, _: object) -> None:
        # Other objects may fill the youngest generation once.
        looked.append(phase)

    gc.callbacks.append(look)
    try:
        with nullcontext() if end else pytest.raises(RemoteProtocolError):
            await read_request('{"op": "x", "y": [' + "[]," * 25_000 + "[]" + end)
    finally:
        gc.callbacks.remove(look)
    assert gc.isenabled()
    assert looked.count("start") <= 2


@pytest.mark.parametrize(
    "text",
    [
        '{"msg": {"data": [1, -2.5e3 , 0.1,\n7, {"a": [1, 2, [], "x,1,2"]}, 1, 2], "n": [null, true]}}',
        "[" + "3," * 10_000 + "4]",
        "[1, 2",
        "[1, 2,]",
        "[1,, 2]",
        "[01, 2]",
        "[1, 2] 3",
        "[-, 1]",
        '{"a": [1, NaN, 2]}',
        # Deeper than any Python goes; how deep differs.
        "[" * 200_000,
    ],
)
def test_parsing_in_steps_is_parsing(text: str) -> None:
    def outcome(parse: Callable[[str], Any]) -> str:
        try:
            return repr(parse(text))
        except (ValueError, RecursionError) as error:
            return type(error).__name__

    assert outcome(parse_in_steps) == outcome(json.loads)


async def test_a_large_message_does_not_hold_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    text = '{"op": "publish", "msg": {"data": [' + "1," * 500_000 + "1]}}"
    watch = CallbackWatch(monkeypatch)
    request = await read_request(text)
    watch.check("half a million numbers")
    assert len(request.fields["msg"]["data"]) == 500_001
    assert request.value_count > 500_000


async def test_the_containers_of_a_message_are_limited() -> None:
    with pytest.raises(RemoteProtocolError, match="lists and objects"):
        await read_request("[" + "{}," * MAX_CONTAINERS + "{}]")

"""The tf buffer and Debian's tf2 give the same answers after the same transforms."""

from __future__ import annotations

import json
import math
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest

from interop.ros1_peers import DEBIAN_PYTHON
from rostether.errors import (
    ExtrapolationError,
    TransformError,
    UnconnectedFramesError,
    UnknownFrameError,
)
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.transform import StampedTransform, Transform
from tf2_reports import frames_as_string, frames_as_yaml

pytestmark = pytest.mark.robot

PEER = Path(__file__).parent / "peers" / "tf2_buffer.py"
TOLERANCE = 1e-9
SECOND = 10**9

TF2_NAMES: dict[type[TransformError], str] = {
    UnknownFrameError: "LookupException",
    UnconnectedFramesError: "ConnectivityException",
    ExtrapolationError: "ExtrapolationException",
    TransformError: "InvalidArgumentException",
}


def ask_tf2(operations: list[list[Any]]) -> list[dict[str, Any]]:
    text = "".join(json.dumps(operation) + "\n" for operation in operations)
    completed = subprocess.run(
        [DEBIAN_PYTHON, str(PEER)], input=text, capture_output=True, text=True, check=True, timeout=60
    )
    return [json.loads(line) for line in completed.stdout.splitlines()]


def ask_buffer(operations: list[list[Any]]) -> list[dict[str, Any]]:
    buffer = TransformBuffer()
    answers = []
    for name, *arguments in operations:
        try:
            value: Any = None
            match name:
                case "set":
                    parent, child, stamp_ns, translation, rotation, is_static = arguments
                    stamped = StampedTransform(
                        parent, child, stamp_ns, Transform(tuple(translation), tuple(rotation))
                    )
                    buffer.set_transform(stamped, authority="peer", is_static=is_static)
                case "lookup":
                    value = as_record(buffer.lookup(*arguments))
                case "through":
                    value = as_record(buffer.lookup_through(*arguments))
                case "chain":
                    value = buffer.chain(*arguments)
                case "yaml":
                    value = frames_as_yaml(buffer)
                case "string":
                    value = frames_as_string(buffer)
                case "why":
                    value = buffer.lookup_error(*arguments)
            answers.append({"value": value})
        except TransformError as error:
            answers.append({"error": TF2_NAMES[type(error)], "text": str(error)})
    return answers


def as_record(stamped: StampedTransform) -> list[Any]:
    return [stamped.stamp_ns, list(stamped.transform.translation), list(stamped.transform.rotation)]


def compare(operations: list[list[Any]]) -> dict[str, int]:
    """Compare all answers; return the number of answers of each kind."""
    counts: dict[str, int] = {}
    tf2, rostether = ask_tf2(operations), ask_buffer(operations)
    assert len(tf2) == len(rostether) == len(operations)
    for operation, expected, found in zip(operations, tf2, rostether, strict=True):
        kind = expected.get("error", operation[0])
        counts[kind] = counts.get(kind, 0) + 1
        if operation[0] in ("lookup", "through") and "value" in expected:
            assert "value" in found, (operation, found)
            (expected_ns, *expected_numbers), (found_ns, *found_numbers) = expected["value"], found["value"]
            assert found_ns == expected_ns, operation
            for a, b in zip(expected_numbers, found_numbers, strict=True):
                assert b == pytest.approx(a, abs=TOLERANCE), operation
        else:
            assert found == expected, operation
    return counts


def random_rotation(rng: random.Random) -> list[float]:
    numbers = [rng.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(each * each for each in numbers))
    return [each / length for each in numbers]


def random_session(seed: int) -> list[list[Any]]:
    rng = random.Random(seed)
    frames = [f"f{number}" for number in range(12)]
    parents = {frame: rng.choice(frames[:position]) for position, frame in enumerate(frames) if position}
    parents["f11"] = "elsewhere"
    static = {frame for frame in parents if rng.random() < 0.3}
    operations: list[list[Any]] = []
    for _ in range(400):
        at = rng.randrange(100 * SECOND, 112 * SECOND)
        what = rng.random()
        if what < 0.45:
            child = rng.choice(list(parents))
            position = [rng.uniform(-2, 2) for _ in range(3)]
            parent = parents[child] if rng.random() < 0.98 else "f0"
            operations.append(["set", parent, child, at, position, random_rotation(rng), child in static])
        elif what < 0.8:
            target, source = rng.choices([*frames, "elsewhere", "nowhere"], k=2)
            operations.append(["lookup", target, source, 0 if rng.random() < 0.4 else at])
        elif what < 0.9:
            target, source, fixed = rng.choices(frames, k=3)
            operations.append(["through", target, 0, source, at, fixed])
        elif what < 0.95:
            operations.append(["why", *rng.choices([*frames, "nowhere"], k=2), at])
        else:
            operations.append([rng.choice(["string", "yaml"])])
    return operations


@pytest.mark.parametrize("seed", range(6))
def test_random_trees_give_the_same_transforms_and_errors(seed: int) -> None:
    counts = compare(random_session(seed))
    assert counts["lookup"] > 10
    assert counts["ExtrapolationException"] > 5


IDENTITY = [0.0, 0.0, 0.0, 1.0]


def set_operation(parent: str, child: str, at_s: float, **options: Any) -> list[Any]:
    return [
        "set",
        parent,
        child,
        round(at_s * SECOND),
        options.get("at", [1.0, 0.0, 0.0]),
        options.get("turned", IDENTITY),
        options.get("is_static", False),
    ]


def test_a_loop_is_reported() -> None:
    counts = compare(
        [
            set_operation("y", "x", 100),
            set_operation("x", "y", 100),
            set_operation("x", "w", 100),
            set_operation("a", "b", 100),
            ["lookup", "w", "a", 0],
            ["lookup", "x", "y", 0],
            ["lookup", "w", "b", 100 * SECOND],
        ]
    )
    assert counts["LookupException"] == 2


def test_illegal_names_are_refused() -> None:
    compare(
        [
            set_operation("/a", "/b", 100),
            ["lookup", "a", "b", 0],
            ["lookup", "/a", "b", 0],
            ["lookup", "a", "/b", 0],
            ["lookup", "", "b", 0],
            ["lookup", "zz", "zz", 0],
            ["lookup", "a", "a", 0],
            ["lookup", "b", "b", 0],
            ["string"],
        ]
    )


@pytest.mark.parametrize(
    "refused",
    [
        set_operation("a", "a", 101),
        set_operation("", "c", 101),
        set_operation("a", "", 101),
        set_operation("a", "b", 101, turned=[0.0, 0.0, 0.0, 2.0]),
        set_operation("a", "b", 101, turned=[0.0, 0.0, 0.0, 0.0]),
        set_operation("a", "b", 101, turned=[0.0, 0.0, 0.0, 1.004]),
        set_operation("a", "b", 101, turned=[0.0, 0.0, 0.0, 1.006]),
        set_operation("a", "b", 101, at=[math.nan, 0.0, 0.0]),
        set_operation("a", "b", 100, at=[5.0, 0.0, 0.0]),
        set_operation("a", "b", 80),
        set_operation("a", "b", 90, at=[5.0, 0.0, 0.0]),
        set_operation("c", "b", 101, at=[5.0, 0.0, 0.0]),
        set_operation("a", "b", 101, is_static=True),
    ],
)
def test_a_refused_transform_changes_nothing(refused: list[Any]) -> None:
    questions = [["lookup", "a", "b", at] for at in (0, 90 * SECOND, 95 * SECOND, 100 * SECOND, 101 * SECOND)]
    compare([set_operation("a", "b", 100), refused, *questions, ["string"], ["yaml"]])


def test_old_transforms_are_removed() -> None:
    moves = [set_operation("a", "b", 100 + step, at=[float(step), 0.0, 0.0]) for step in range(15)]
    compare([*moves, *(["lookup", "a", "b", at * SECOND] for at in range(98, 117)), ["yaml"]])


def test_interpolation_uses_the_shorter_rotation() -> None:
    half = math.sqrt(0.5)
    compare(
        [
            set_operation("a", "b", 100, turned=[half, 0.0, 0.0, half]),
            set_operation("a", "b", 101, turned=[0.0, -half, 0.0, -half]),
            set_operation("a", "b", 102, turned=[0.0, half, 0.0, half]),
            *(["lookup", "a", "b", 100 * SECOND + part * SECOND // 7] for part in range(15)),
        ]
    )


def test_the_chain_between_two_frames() -> None:
    compare(
        [
            set_operation("root", "a", 100),
            set_operation("a", "a1", 100),
            set_operation("root", "b", 100),
            set_operation("b", "b1", 100, is_static=True),
            ["lookup", "a1", "b1", 0],
            ["lookup", "b1", "a1", 0],
            ["lookup", "root", "a1", 0],
            ["lookup", "a1", "root", 0],
            ["chain", "root", "a1"],
        ]
    )

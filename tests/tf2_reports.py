"""The frames of a tf buffer in the text forms of tf2."""

from __future__ import annotations

from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_report import frame_facts


def frames_as_yaml(buffer: TransformBuffer) -> str:
    """Return tf2's all_frames_as_yaml."""
    text = "".join(
        f"{each.frame}: \n"
        f"  parent: '{each.parent}'\n"
        f"  broadcaster: '{each.broadcaster}'\n"
        f"  rate: {each.rate_hz:.3f}\n"
        f"  most_recent_transform: {each.latest_s:.3f}\n"
        f"  oldest_transform: {each.oldest_s:.3f}\n"
        f"  buffer_length: {each.buffer_length_s:.3f}\n"
        for each in frame_facts(buffer)
    )
    return text or "{}"


def frames_as_string(buffer: TransformBuffer) -> str:
    """Return tf2's all_frames_as_string."""
    return "".join(f"Frame {each.frame} exists with parent {each.parent}.\n" for each in frame_facts(buffer))

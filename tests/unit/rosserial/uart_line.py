"""What a UART makes of bytes that were sent at another baud rate: bits sampled at the wrong times."""

from __future__ import annotations

from itertools import pairwise


def garbled(data: bytes, sent_at: int, received_at: int, *, gap_bits: int = 0) -> bytes:
    """Return what a receiver at `received_at` baud reads of 8N1 bytes sent at `sent_at`, `gap_bits` apart.

    The receiver starts at a falling edge, samples the middle of each bit, and takes bytes with a framing
    error as they are, like the drivers in use.
    """
    levels = [1]
    for byte in data:
        levels += [0, *((byte >> bit) & 1 for bit in range(8)), 1, *[1] * gap_bits]
    levels += [1] * 12
    if sent_at == received_at:
        return data
    falls = [index for index, (before, after) in enumerate(pairwise(levels), 1) if before and not after]
    received = bytearray()
    ready = 0.0
    step = sent_at / received_at
    for fall in falls:
        if fall < ready:
            continue
        byte = 0
        for bit in range(8):
            place = int(fall + (bit + 1.5) * step)
            byte |= (levels[place] if place < len(levels) else 1) << bit
        received.append(byte)
        ready = fall + 9.5 * step
    return bytes(received)

"""Faults of a line, from a seed: flipped, lost and inserted bytes, as from bad cables and boot noise."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from rostether.transports.memory import Direction


@dataclass(frozen=True, slots=True)
class FaultRates:
    """The probabilities of faults, for each byte or each chunk."""

    flip_per_byte: float = 0.0
    lose_per_byte: float = 0.0
    insert_per_byte: float = 0.0
    lose_per_chunk: float = 0.0


class LineFaults:
    """Damages chunks, as a `manipulator` of `memory_pair`. The same seed gives the same faults."""

    def __init__(self, rates: FaultRates, seed: int) -> None:
        self.fault_count = 0
        self._rates = rates
        self._rng = Random(seed)

    def __call__(self, chunk: bytes, _direction: Direction) -> bytes:
        """Return the part of a chunk that arrives, with its faults."""
        rates, rng = self._rates, self._rng
        if rates.lose_per_chunk and rng.random() < rates.lose_per_chunk:
            self.fault_count += 1
            return b""
        arrived = bytearray()
        for byte in chunk:
            fault = rng.random()
            if fault < rates.flip_per_byte:
                arrived.append(byte ^ 1 << rng.randrange(8))
            elif fault < rates.flip_per_byte + rates.lose_per_byte:
                pass
            elif fault < rates.flip_per_byte + rates.lose_per_byte + rates.insert_per_byte:
                arrived += bytes((byte, rng.randrange(256)))
            else:
                arrived.append(byte)
                continue
            self.fault_count += 1
        return bytes(arrived)

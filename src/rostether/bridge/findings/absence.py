"""Why no board answers, based on the bytes received instead of frames."""

from __future__ import annotations

from rostether.bridge.findings.finding import Code, Finding, error
from rostether.bridge.findings.noise import Noise, is_text, show


def absence(noise: Noise, baud: int | None, waited_s: float) -> Finding:
    """Return why there is no rosserial frame, based on the bytes received instead."""
    if not noise.byte_count:
        hint = f", and whether its baud rate is {baud}" if baud else ""
        return error(
            Code.NOTHING_RECEIVED,
            f"no answer from the board for {waited_s:.0f} s: no byte was received",
            "check that its sketch runs rosserial on this port (nh.initNode() in setup(), nh.spinOnce() in "
            f"loop()){hint}, and that the cable carries data",
        )
    what = (
        f"no rosserial frame for {waited_s:.0f} s, but {noise.byte_count} other bytes ({show(noise.sample)})"
    )
    if is_text(noise.sample):
        return error(
            Code.TEXT_RECEIVED,
            f"{what}: text that the sketch prints on this port (Serial.print)",
            "upload a sketch that runs rosserial, remove Serial.print from it, or print on another port",
        )
    if noise.other_version is not None:
        return error(
            Code.PROTOCOL_VERSION,
            f"{what}: frames of an unknown protocol version (version byte {noise.other_version:#04x})",
            "generate the client library again with rostether firmware lib and upload the sketch",
        )
    if baud:
        return error(
            Code.WRONG_BAUD,
            f"{what}: probably a baud rate other than {baud}",
            "give the rate of the sketch's setBaud() or Serial.begin() as ?baud=...; rostether doctor "
            "finds it",
        )
    return error(
        Code.NOISE_RECEIVED,
        what,
        "check that a rosserial board is connected here, with the same baud rate on both sides of a "
        "converter",
    )

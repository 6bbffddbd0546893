"""`python -m fuzz TARGET --seconds N`: look for inputs that break a promise; see fuzz/README.md."""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
import traceback
from pathlib import Path

HERE = Path(__file__).parent
# The seeds are recordings and helpers of the tests.
sys.path.insert(0, str(HERE.parent / "tests"))

from fuzz import targets  # noqa: E402
from fuzz.mutations import MAX_INPUT_BYTES  # noqa: E402
from fuzz.planting import PlantDoesNotApplyError, sow  # noqa: E402
from fuzz.plants import PLANTS  # noqa: E402

FOUND = HERE / "found"


def main() -> int:
    """Fuzz one target or all, one after the other; return 1 if an input broke a promise."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("target", choices=[*targets.NAMES, "all"])
    parser.add_argument("--seconds", type=float, default=60.0, help="for each target (default: 60)")
    parser.add_argument("--seed", type=int, default=None, help="for the random changes (default: the time)")
    parser.add_argument("--keep", action="store_true", help="keep inputs that reach new code (atheris only)")
    parser.add_argument("--no-atheris", action="store_true", help="change inputs blindly, without coverage")
    parser.add_argument("--input", type=Path, help="run one file instead, and show what it does")
    parser.add_argument("--plant", choices=PLANTS, help="plant this fault first; --seconds is then CPU time")
    arguments = parser.parse_args()
    if arguments.plant is not None:
        try:
            sow(PLANTS[arguments.plant])
        except PlantDoesNotApplyError as error:
            parser.error(str(error))
    if arguments.input is not None:
        targets.load(arguments.target).check(arguments.input.read_bytes())
        return 0
    names = targets.NAMES if arguments.target == "all" else (arguments.target,)
    if (
        not arguments.no_atheris
        and arguments.plant is None
        and len(names) == 1
        and _run_atheris(names[0], arguments)
    ):
        return 0
    seed = time.time_ns() if arguments.seed is None else arguments.seed
    is_planted = arguments.plant is not None
    return max([_run_mutations(name, arguments.seconds, seed, is_planted=is_planted) for name in names])


def _run_mutations(name: str, seconds: float, seed: int, *, is_planted: bool) -> int:
    # A planted fault must be found in a fixed CPU time, even on a busy machine.
    clock = time.process_time if is_planted else time.monotonic
    target = targets.load(name)
    count, began_s = 0, clock()
    for data in target.inputs(seed):
        if clock() - began_s > seconds:
            break
        count += 1
        try:
            target.check(data, is_traced=count % targets.TRACE_EVERY == 0)
        except Exception:  # noqa: BLE001 - finding these is what this is for
            traceback.print_exc()
            where = f"input {count} after {clock() - began_s:.1f} s"
            if not is_planted:
                FOUND.mkdir(exist_ok=True)
                path = FOUND / f"{name}-{hashlib.sha1(data, usedforsecurity=False).hexdigest()[:12]}"
                path.write_bytes(data)
                where = f"{path}; see python -m fuzz {name} --input {path}"
            print(f"{name} breaks a promise (seed {seed}): {where}", flush=True)
            return 1
    print(f"{name}: {count} inputs, nothing found (seed {seed})", flush=True)
    return 0


def _run_atheris(name: str, arguments: argparse.Namespace) -> bool:
    """Run under atheris, which ends the process; False when it is not installed."""
    try:
        import atheris
    except ImportError:
        return False
    with atheris.instrument_imports(include=["rostether"]):
        target = targets.load(name)
    kept = targets.CORPORA / name
    seeds = FOUND / f"{name}-corpus"
    for folder in (kept, seeds):
        folder.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(target.seeds()):
        (seeds / f"seed-{number}").write_bytes(data)
    folders = [kept, seeds] if arguments.keep else [seeds, kept]
    options = [
        f"-max_total_time={int(arguments.seconds)}",
        f"-max_len={MAX_INPUT_BYTES}",
        f"-artifact_prefix={FOUND}/{name}-",
        "-timeout=5",
        "-rss_limit_mb=1024",
        *([] if arguments.seed is None else [f"-seed={arguments.seed & 0x7FFFFFFF}"]),
    ]
    atheris.Setup([sys.argv[0], *options, *map(str, folders)], target.check)
    atheris.Fuzz()
    return True


if __name__ == "__main__":
    sys.exit(main())

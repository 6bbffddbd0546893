"""A C++ program that reads, writes and fills messages of many types with their headers."""

from __future__ import annotations

import fcntl
import hashlib
import os
import struct
import subprocess
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rostether.codegen.cpp_names import qualified_class
from rostether.codegen.type_index import TypeIndex

# A message for each kind of undefined behavior would double the time to compile.
SANITIZERS = ("-fsanitize=address,undefined", "-fsanitize-undefined-trap-on-error")
KEPT_S = 3600.0  # other test processes may still run an older program
ARENA_BYTES = 1 << 20  # space for arrays of strings and of messages, in addition to the payload

_PROGRAM = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

namespace {

const size_t kArena = %(arena)d;

template <class M>
void answer(int result, const M& message) {
  const uint32_t length = result < 0 ? 0 : static_cast<uint32_t>(message.serializedLength());
  unsigned char* out = static_cast<unsigned char*>(malloc(length + 1));
  const int32_t written = result < 0 ? -1 : message.serialize(out, length);
  const int32_t read = result;
  fwrite(&read, 4, 1, stdout);
  fwrite(&written, 4, 1, stdout);
  fwrite(&length, 4, 1, stdout);
  fwrite(out, 1, length, stdout);
  free(out);
}

// A message that was used before, as a subscriber's is.
template <class M>
void roundTrip(const unsigned char* payload, size_t length) {
  static M message;
  unsigned char* memory = static_cast<unsigned char*>(malloc(length + kArena + 4));
  unsigned char* buffer = memory + 4;
  memcpy(buffer, payload, length);
  answer(message.deserialize(buffer, length, length + kArena), message);
  message = M();
  free(memory);
}

template <class M>
void fill(void (*assign)(M&)) {
  static M message;
  assign(message);
  answer(0, message);
}

%(assignments)s

}  // namespace

int main() {
  uint32_t head[2];
  while (fread(head, 4, 2, stdin) == 2) {
    unsigned char* payload = static_cast<unsigned char*>(malloc(head[1] + 1));
    if (fread(payload, 1, head[1], stdin) != head[1]) return 1;
    switch (head[0]) {
%(cases)s
      default: return 2;
    }
    free(payload);
  }
  return 0;
}
"""


@dataclass(frozen=True, slots=True)
class Answer:
    """The results of deserialize and serialize, and the bytes that serialize wrote."""

    read: int
    written: int
    payload: bytes


class WireProgram:
    """Reads payloads and writes them back; fills messages like sketches."""

    def __init__(
        self, index: TypeIndex, library: Path, types: Sequence[str], assignments: Sequence[tuple[str, str]]
    ) -> None:
        """`assignments` are (type, body of a function that fills `message`)."""
        self._numbers = {name: number for number, name in enumerate(types)}
        self._first_assignment = len(types)
        cases = [
            f"      case {number}: roundTrip<{qualified_class(name)}>(payload, head[1]); break;"
            for name, number in self._numbers.items()
        ]
        functions = []
        for number, (name, body) in enumerate(assignments):
            functions.append(f"void assign{number}({qualified_class(name)}& message) {{\n{body}}}\n")
            case = len(types) + number
            cases.append(f"      case {case}: fill<{qualified_class(name)}>(assign{number}); break;")
        headers = sorted({index.header_of(name) for name in types})
        source = "".join(f"#include <{name}.h>\n" for name in headers) + _PROGRAM % {
            "arena": ARENA_BYTES,
            "assignments": "\n".join(functions),
            "cases": "\n".join(cases),
        }
        self._program = _built(source, library)

    def round_trips(self, payloads: Iterable[tuple[str, bytes]]) -> list[Answer]:
        """Read each payload as a message of a type, and write it back."""
        return self._ask((self._numbers[name], payload) for name, payload in payloads)

    def filled(self, count: int) -> list[Answer]:
        """Return the messages that the assignments fill."""
        return self._ask((self._first_assignment + number, b"") for number in range(count))

    def _ask(self, requests: Iterable[tuple[int, bytes]]) -> list[Answer]:
        stdin = b"".join(struct.pack("<II", number, len(data)) + data for number, data in requests)
        environ = {"ASAN_OPTIONS": "handle_sigill=1"}
        done = subprocess.run([self._program], env=environ, input=stdin, capture_output=True, timeout=120)
        assert done.returncode == 0, done.stderr.decode(errors="replace")
        return list(_answers(done.stdout))


def _answers(output: bytes) -> Iterator[Answer]:
    position = 0
    while position < len(output):
        read, written, length = struct.unpack_from("<iiI", output, position)
        position += 12
        yield Answer(read, written, output[position : position + length])
        position += length


def _built(source: str, library: Path) -> Path:
    """Return the compiled program, built once for all test processes."""
    headers = sorted((library / "src").rglob("*.h"))
    digest = hashlib.sha256(source.encode() + b"".join(header.read_bytes() for header in headers)).hexdigest()
    folder = Path(tempfile.gettempdir()) / f"rostether-peers-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    program = folder / f"wire-{digest[:16]}"
    with (folder / "wire-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not program.exists():
            for old in folder.glob("wire-????????????????*"):
                if old.stat().st_mtime < time.time() - KEPT_S:
                    old.unlink()
            file = program.with_suffix(".cpp")
            file.write_text(source)
            unfinished = program.with_suffix(".new")
            # Not gnu++11, where the name of a field, `linux`, is a macro with the value 1.
            flags = ["-std=c++11", "-Wall", "-Wextra", "-Werror", f"-I{library}/src"]
            subprocess.run(["g++", *flags, *SANITIZERS, "-o", unfinished, file], check=True)
            unfinished.rename(program)
    return program

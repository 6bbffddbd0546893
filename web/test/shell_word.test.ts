// Topic names in command lines that people copy.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { test } from "node:test";
import { shellWord } from "../src/shell/shell_word.ts";

test("a shell reads every copied name literally", () => {
  assert.equal(shellWord("/robot/imu"), "/robot/imu");
  for (const name of ["/$(echo x)", "/`echo x`", "/a;echo x", '/it\'s "b"', "/*", "~", "/a\nb"]) {
    assert.equal(execFileSync("sh", ["-c", `printf %s ${shellWord(name)}`], { encoding: "utf8" }), name);
  }
});

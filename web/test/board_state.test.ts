// States of simulated boards, and other messages on their topic.
import assert from "node:assert/strict";
import { test } from "node:test";
import { readBoardState, simulatedBoards } from "../src/panels/simulation/board_state.ts";

test("a state is read", () => {
  const state = readBoardState(
    JSON.stringify({
      board: "uno",
      mcu: "atmega328p",
      pins: { D9: "pwm0.503", D13: "out1", A0: "in0", D1: "?" },
      servos: { D10: 90.5 },
      values: { range: "0.5", adc: { A0: "2.5", A1: "x" }, pin: { D7: "1", D8: "z" } },
      commands: ["adc", "pin"],
      max_volts: 3.3,
      error: "",
    }),
  );
  assert.ok(state);
  assert.deepEqual([state.commands, state.maxVolts], [["adc", "pin"], 3.3]);
  assert.deepEqual(state.pins, [
    { name: "D9", direction: "pwm", level: 0.503 },
    { name: "D13", direction: "out", level: 1 },
    { name: "A0", direction: "in", level: 0 },
  ]);
  assert.deepEqual([state.servos, state.values], [{ D10: 90.5 }, { range: "0.5" }]);
  assert.deepEqual([state.volts, state.driven], [{ A0: 2.5 }, { D7: 1 }]);
});

test("a message that is not a state shows nothing", () => {
  for (const text of [undefined, "", "{", "3"]) assert.deepEqual(readBoardState(text)?.pins ?? [], []);
  const boards = simulatedBoards([
    { name: "/lab/sonar_simulation/state", typeName: "std_msgs/String" },
    { name: "/other_simulation/state", typeName: "std_msgs/Int16" },
  ]);
  assert.deepEqual([...boards], [["/lab/sonar_simulation/state", "/lab/sonar"]]);
});

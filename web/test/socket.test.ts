// A connection on a network that has failed, which browsers do not report.
import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { ReconnectingSocket } from "../src/connection/socket.ts";

class FakeSocket {
  static readonly OPEN = 1;
  static made: FakeSocket[] = [];
  readonly readyState = FakeSocket.OPEN;
  readonly sent: string[] = [];
  isClosed = false;
  onmessage: (event: { data: string }) => void = () => {};

  constructor() {
    FakeSocket.made.push(this);
  }

  send(data: string): void {
    this.sent.push(data);
  }

  close(): void {
    this.isClosed = true;
  }
}

const page = { addEventListener: () => {}, removeEventListener: () => {} };
Object.assign(globalThis, { ...page, document: page, WebSocket: FakeSocket });

test("a server that does not answer is connected again", () => {
  mock.timers.enable({ apis: ["setInterval", "setTimeout"] });
  const seen: string[] = [];
  const socket = new ReconnectingSocket(() => "ws://robot", [], {
    onMessage: (data) => data === "hello",
    onClose: () => seen.push("closed"),
    probe: { op: "ask" },
    onSilence: () => seen.push("silent"),
  });
  const first = FakeSocket.made[0] as FakeSocket;
  first.onmessage({ data: "hello" });
  for (let second = 0; second < 60; second++) {
    mock.timers.tick(1000);
    if (second % 12 === 11) first.onmessage({ data: "answer" });
  }
  assert.deepEqual(seen, []);
  assert.deepEqual(new Set(first.sent), new Set(['{"op":"ask"}']));
  mock.timers.tick(20_000);
  mock.timers.tick(1000);
  assert.deepEqual(seen, ["silent", "closed"]);
  assert.ok(first.isClosed);
  assert.equal(FakeSocket.made.length, 2);
  socket.close();
  mock.timers.reset();
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { RateMeter } from "../src/store/rate.ts";

function add(meter: RateMeter, fromMs: number, toMs: number, periodMs: number): void {
  for (let ms = fromMs; ms < toMs; ms += periodMs) meter.add(ms, 10);
}

test("the rate of regular messages, slow and fast", () => {
  for (const hertz of [1, 50, 1000]) {
    const meter = new RateMeter();
    if (hertz > 1) meter.start(0);
    add(meter, 1, 20_001, 1000 / hertz);
    assert.ok(Math.abs(meter.hertz(20_001) / hertz - 1) < 0.001, `${hertz}: ${meter.hertz(20_001)}`);
    assert.ok(Math.abs(meter.bytesPerSecond(20_001) - 10 * meter.hertz(20_001)) < 1e-6);
    assert.equal(meter.hertz(30_000), 0);
  }
});

test("messages that waited for a busy page do not count as a burst", () => {
  const meter = new RateMeter();
  meter.start(0);
  // The page needs 2 s to start, and is later busy for 1 s.
  for (let message = 0; message < 100; message++) meter.add(2000 + message * 0.1, 10);
  assert.ok(Math.abs(meter.hertz(2010) - 50) < 1, String(meter.hertz(2010)));
  add(meter, 2020, 9000, 20);
  for (let message = 0; message < 50; message++) meter.add(10_000 + message * 0.1, 10);
  assert.ok(Math.abs(meter.hertz(10_005) - 50) < 2, String(meter.hertz(10_005)));
});

test("two latched messages do not give a high rate", () => {
  const meter = new RateMeter();
  meter.start(0);
  meter.add(5, 10);
  meter.add(6, 10);
  assert.ok(meter.hertz(100) <= 2);
});

test("a pause without a subscription does not count as a period", () => {
  const meter = new RateMeter();
  meter.start(0);
  add(meter, 1, 1000, 100);
  meter.start(600_000);
  assert.ok(meter.isStale(600_000));
  add(meter, 600_001, 601_000, 100);
  assert.ok(Math.abs(meter.hertz(601_000) - 10) < 0.1);
  assert.ok(!meter.isStale(601_100));
  assert.ok(meter.isStale(601_500));
});

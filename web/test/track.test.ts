import assert from "node:assert/strict";
import { test } from "node:test";
import { nearestLongitude, Track } from "../src/panels/map/track.ts";

test("a track is bounded, and keeps its ends", () => {
  const track = new Track();
  for (let i = 0; i < 50_000; i++) track.add({ latitude: i * 1e-5, longitude: 0 });
  assert.ok(track.positions.length <= 20_000);
  assert.deepEqual([track.positions[0]!.latitude, track.positions.at(-1)!.latitude], [0, 49_999 * 1e-5]);
});

test("a robot that crosses the date line stays near itself", () => {
  assert.equal(nearestLongitude(-179.9, 179.9), 180.1);
  assert.equal(nearestLongitude(179.9, -179.9), -180.1);
  assert.equal(nearestLongitude(11.5, 0), 11.5);
});

import assert from "node:assert/strict";
import { test } from "node:test";
import { ClockOffset } from "../src/phone/clock_offset.ts";
import { phoneType } from "../src/phone/definitions.ts";
import { attitude } from "../src/phone/imu.ts";
import { rateLimiter } from "../src/phone/sensor.ts";
import { decoder } from "../src/wire/decode.ts";
import { encoder } from "../src/wire/encode.ts";

test("the robot's time is that of the quickest answer", () => {
  const clock = new ClockOffset();
  assert.equal(clock.stamp(0), undefined);
  // The robot is 5 s ahead; the first answer waited 80 ms on its way back.
  clock.add(1000, 1100, { sec: 6, nsec: 10_000_000 });
  clock.add(2000, 2010, { sec: 7, nsec: 5_000_000 });
  assert.deepEqual(clock.best, { offsetMs: 5000, roundTripMs: 10 });
  assert.deepEqual(clock.stamp(2999.5), { sec: 7, nsec: 999_500_000 });
  // A clock that was set is followed when the old answers are gone.
  for (let index = 0; index < 8; index++) clock.add(index, index + 20, { sec: 0, nsec: index * 1e6 + 10e6 });
  assert.equal(clock.best?.offsetMs, 0);
});

test("the attitude of a phone, from its three angles", () => {
  const near = (angles: [number, number, number], wanted: number[]) => {
    const { x, y, z, w } = attitude(...angles);
    [x, y, z, w].forEach((each, index) => {
      assert.ok(Math.abs(each - wanted[index]!) < 1e-9, `${angles}: ${[x, y, z, w]}`);
    });
  };
  const half = Math.SQRT1_2;
  near([0, 0, 0], [0, 0, 0, 1]);
  near([90, 0, 0], [0, 0, half, half]);
  near([0, 90, 0], [half, 0, 0, half]);
  near([0, 0, 90], [0, half, 0, half]);
  // About z, then the new x: the product of the two.
  near([90, 90, 0], [0.5, 0.5, 0.5, 0.5]);
});

test("a rate is not exceeded, and uneven events do not halve it", () => {
  const passed = (hertz: number, everyMs: number) => {
    const passes = rateLimiter(hertz);
    let count = 0;
    for (let ms = 0; ms < 10_000; ms += everyMs) if (passes(ms + (ms % 3))) count++;
    return count;
  };
  assert.ok(Math.abs(passed(50, 16) - 500) < 10);
  assert.ok(Math.abs(passed(10, 100) - 100) < 3);
  assert.equal(passed(0, 16), 625);
  assert.ok(passed(5, 1) <= 52);
});

test("the bytes of a picture are copied like a list", () => {
  const type = phoneType("sensor_msgs/CompressedImage");
  const encode = encoder(type);
  const data = Uint8Array.from({ length: 1000 }, (_, index) => index);
  const payload = encode({ format: "jpeg", data });
  assert.deepEqual(payload, encode({ format: "jpeg", data: [...data] }));
  assert.deepEqual(decoder(type)(payload).data, data);
});

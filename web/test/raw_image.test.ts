import assert from "node:assert/strict";
import { test } from "node:test";
import { type RawImage, toRgba } from "../src/panels/images/raw_image.ts";

function image(
  encoding: string,
  width: number,
  height: number,
  data: number[],
  step = data.length / height,
): RawImage {
  return { encoding, width, height, step, data: Uint8Array.from(data), is_bigendian: 0 };
}

test("colors in each order of bytes", () => {
  assert.deepEqual([...toRgba(image("rgb8", 1, 1, [1, 2, 3]))], [1, 2, 3, 255]);
  assert.deepEqual([...toRgba(image("bgr8", 1, 1, [1, 2, 3]))], [3, 2, 1, 255]);
  assert.deepEqual([...toRgba(image("bgra8", 1, 1, [1, 2, 3, 9]))], [3, 2, 1, 255]);
  assert.deepEqual([...toRgba(image("mono8", 2, 1, [7, 8]))], [7, 7, 7, 255, 8, 8, 8, 255]);
});

test("rows may be padded", () => {
  assert.deepEqual([...toRgba(image("mono8", 1, 2, [5, 0, 6, 0]))], [5, 5, 5, 255, 6, 6, 6, 255]);
});

test("wide numbers are stretched", () => {
  const pixels = toRgba(image("mono16", 3, 1, [0, 0, 0, 8, 0, 16]));
  assert.deepEqual([pixels[0], pixels[4], pixels[8]], [0, 128, 255]);
  const big = { ...image("mono16", 2, 1, [0, 1, 1, 0]), is_bigendian: 1 };
  assert.deepEqual([toRgba(big)[0], toRgba(big)[4]], [0, 255]);
});

test("infinite and missing distances leave the others visible", () => {
  const distances = new Uint8Array(
    new Float32Array([Number.NaN, Number.NEGATIVE_INFINITY, Number.POSITIVE_INFINITY, 1, 3]).buffer,
  );
  const pixels = toRgba(image("32FC1", 5, 1, [...distances]));
  assert.deepEqual(
    [0, 4, 8, 12, 16].map((at) => pixels[at]),
    [0, 0, 255, 0, 255],
  );
});

test("signed, double and 16 bit numbers", () => {
  const signed = toRgba(image("16SC1", 2, 1, [0, 0xff, 0, 1]));
  assert.deepEqual([signed[0], signed[4]], [0, 255]);
  const doubles = toRgba(image("64FC1", 2, 1, [...new Uint8Array(new Float64Array([-5, 5]).buffer)]));
  assert.deepEqual([doubles[0], doubles[4]], [0, 255]);
  const deep = image("rgb16", 1, 1, [9, 1, 9, 2, 9, 3]);
  assert.deepEqual([...toRgba(deep)], [1, 2, 3, 255]);
  assert.deepEqual([...toRgba({ ...deep, is_bigendian: 1 })], [9, 9, 9, 255]);
  const cells = image("bayer_rggb16", 2, 2, [0, 200, 0, 100, 0, 100, 0, 50]);
  assert.deepEqual([...toRgba(cells).subarray(0, 4)], [200, 100, 50, 255]);
  assert.throws(
    () => toRgba(image("X".repeat(1e6), 1, 1, [1])),
    (error: Error) => error.message.length < 200,
  );
});

test("colors in a plane of their own", () => {
  // Two rows of luma, then u and v of all four pixels: red.
  const red = toRgba(image("nv12", 2, 2, [81, 81, 81, 81, 90, 240], 2));
  assert.deepEqual([...red.subarray(12)], [254, 0, 0, 255]);
  assert.deepEqual(toRgba(image("nv21", 2, 2, [81, 81, 81, 81, 240, 90], 2)), red);
  const blue = toRgba(image("nv24", 2, 1, [81, 41, 90, 240, 240, 110], 2));
  assert.deepEqual([...blue], [254, 0, 0, 255, 0, 0, 255, 255]);
  assert.throws(() => toRgba(image("nv12", 2, 2, [81, 81, 81, 81, 90], 2)), /needs more than 5 bytes/);
  assert.throws(() => toRgba(image("nv21", 3, 2, [1, 2, 3, 4, 5, 6, 7, 8, 9], 3)), /even width/);
});

test("yuv422 in both orders", () => {
  const white = toRgba(image("yuv422", 2, 1, [128, 235, 128, 235]));
  assert.deepEqual([...white], [255, 255, 255, 255, 255, 255, 255, 255]);
  assert.deepEqual([...toRgba(image("yuv422_yuy2", 2, 1, [235, 128, 235, 128]))], [...white]);
  const red = toRgba(image("uyvy", 2, 1, [90, 81, 240, 81]));
  assert.ok(red[0]! > 240 && red[1]! < 15 && red[2]! < 15, `${red}`);
});

test("bayer patterns give the color of their cells", () => {
  for (const [pattern, cells] of Object.entries({
    rggb: [200, 100, 100, 50],
    bggr: [50, 100, 100, 200],
    gbrg: [100, 50, 200, 100],
    grbg: [100, 200, 50, 100],
  })) {
    const rows = [cells[0]!, cells[1]!, cells[0]!, cells[1]!, cells[2]!, cells[3]!, cells[2]!, cells[3]!];
    const pixels = toRgba(image(`bayer_${pattern}8`, 4, 2, rows));
    assert.deepEqual([...pixels.subarray(0, 4)], [200, 100, 50, 255], pattern);
    assert.deepEqual([...pixels.subarray(-4)], [200, 100, 50, 255], pattern);
  }
});

test("pictures that cannot be shown are refused with a sentence", () => {
  const refused: RawImage[] = [
    image("h264", 1, 1, [1]),
    image("rgb8", 2, 2, [1, 2, 3]),
    image("rgb8", 0, 0, [], 0),
    image("mono8", 100_000, 100_000, [], 100_000),
    image("yuv422", 3, 1, [1, 2, 3, 4, 5, 6]),
    image("bayer_rggb8", 1, 1, [1]),
  ];
  for (const each of refused) assert.throws(() => toRgba(each), { name: "Error", message: /image|encoding/ });
});

// Depth pictures. Pillow decodes the same file to the same pixels.
import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeDepth } from "../src/panels/images/compressed_depth.ts";
import { decodeGray16 } from "../src/panels/images/gray_png.ts";

/** 3 x 5 pixels, each row with another filter, in two IDAT chunks. */
const FILE = Uint8Array.from(
  atob(
    "iVBORw0KGgoAAAANSUhEUgAAAAMAAAAFEAAAAAD1itU9AAAACUlEQVR42gEjANz/AM+DGCuLAAAAJUlEQVS+Fe0t7wE8n/LOn7MCoudnmz32A6nV//s/0QSH8NubyehUsRSHEsM5lQAAAABJRU5ErkJggg==",
  ),
  (each) => each.charCodeAt(0),
);
const PIXELS = [
  53182, 5613, 11759, 15519, 11885, 52512, 56966, 38152, 2582, 6168, 21771, 28385, 40712, 31395, 17353,
];

function pixels(data: Uint8Array): number[] {
  const view = new DataView(data.buffer, data.byteOffset);
  return Array.from({ length: data.length / 2 }, (_, at) => view.getUint16(2 * at));
}

/** As compressed_depth_image_transport: the kind, then the parameters of the quantization. */
function withHeader(a: number, b: number): Uint8Array<ArrayBuffer> {
  const message = new Uint8Array(12 + FILE.length);
  const header = new DataView(message.buffer);
  header.setFloat32(4, a, true);
  header.setFloat32(8, b, true);
  message.set(FILE, 12);
  return message;
}

test("PNG keeps 16 bits of gray", async () => {
  const picture = await decodeGray16(FILE);
  assert.deepEqual([picture?.width, picture?.height], [3, 5]);
  assert.deepEqual(pixels(picture!.data), PIXELS);
});

test("other and damaged files", async () => {
  assert.equal(await decodeGray16(Uint8Array.of(0xff, 0xd8, 0xff)), undefined);
  const short = FILE.slice();
  // 255 rows instead of 5.
  short[23] = 255;
  await assert.rejects(decodeGray16(short), /ends too early/);
  const huge = FILE.slice();
  huge.fill(255, 16, 24);
  assert.equal(await decodeGray16(huge), undefined);
});

test("depth in millimeters and in meters", async () => {
  const whole = await decodeDepth("16UC1; compressedDepth png", withHeader(0, 0));
  assert.deepEqual(pixels(whole.data), PIXELS);
  const inverse = await decodeDepth("32FC1; compressedDepth", withHeader(1e4, 100));
  const meters = new Float32Array(inverse.data.buffer);
  assert.equal(inverse.encoding, "32FC1");
  assert.ok(Math.abs(meters[0]! - 1e4 / (53182 - 100)) < 1e-6);
  await assert.rejects(decodeDepth("16UC1; compressedDepth rvl", withHeader(0, 0)), /RVL/);
});

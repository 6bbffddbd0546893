// PNG with 16 bits of gray, such as depth: browsers keep only the upper 8 bits of each pixel.
import type { RawImage } from "./raw_image.ts";
import { MAX_PIXELS } from "./raw_image.ts";

const SIGNATURE = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];
const IHDR = 0x49484452;
const IDAT = 0x49444154;
const PIXEL_BYTES = 2;

/**
 * Decodes a PNG of 16-bit gray pixels (PNG specification, sections 5, 7 and 9).
 *
 * @returns undefined for other files, which the browser can decode.
 * @throws Error with a sentence when the file is damaged.
 */
export async function decodeGray16(file: Uint8Array<ArrayBuffer>): Promise<RawImage | undefined> {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  if (file.length < 33 || SIGNATURE.some((byte, at) => file[at] !== byte) || view.getUint32(12) !== IHDR)
    return undefined;
  const [width, height] = [view.getUint32(16), view.getUint32(20)];
  const isGray16 = file[24] === 16 && file[25] === 0;
  const isInterlaced = file[28] !== 0;
  if (!isGray16 || isInterlaced || width * height > MAX_PIXELS) return undefined;
  const step = width * PIXEL_BYTES;
  const rows = await inflate(compressedParts(file, view), (step + 1) * height);
  return { width, height, step, encoding: "16UC1", is_bigendian: 1, data: unfiltered(rows, step, height) };
}

function compressedParts(file: Uint8Array<ArrayBuffer>, view: DataView): Uint8Array<ArrayBuffer>[] {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  // A chunk is its length, its type, its data and a checksum.
  for (let at = 8; at + 12 <= file.length; ) {
    const length = view.getUint32(at);
    if (view.getUint32(at + 4) === IDAT) parts.push(file.subarray(at + 8, at + 8 + length));
    at += 12 + length;
  }
  return parts;
}

/** Inflates exactly `size` bytes, so that a small file cannot fill the memory. */
async function inflate(parts: Uint8Array<ArrayBuffer>[], size: number): Promise<Uint8Array<ArrayBuffer>> {
  const out = new Uint8Array(size);
  let length = 0;
  const reader = new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  try {
    while (length < size) {
      const { done, value } = await reader.read();
      if (done) break;
      out.set(value.subarray(0, size - length), length);
      length += value.length;
    }
  } finally {
    await reader.cancel().catch(() => undefined);
  }
  if (length < size) throw new Error("This PNG image ends too early.");
  return out;
}

function unfiltered(rows: Uint8Array, step: number, height: number): Uint8Array {
  const out = new Uint8Array(step * height);
  for (let y = 0; y < height; y++) {
    const filter = rows[y * (step + 1)] as number;
    const from = y * (step + 1) + 1;
    const to = y * step;
    for (let x = 0; x < step; x++) {
      const left = x >= PIXEL_BYTES ? (out[to + x - PIXEL_BYTES] as number) : 0;
      const above = y > 0 ? (out[to + x - step] as number) : 0;
      const aboveLeft = x >= PIXEL_BYTES && y > 0 ? (out[to + x - step - PIXEL_BYTES] as number) : 0;
      out[to + x] = (rows[from + x] as number) + predicted(filter, left, above, aboveLeft);
    }
  }
  return out;
}

function predicted(filter: number, left: number, above: number, aboveLeft: number): number {
  switch (filter) {
    case 0:
      return 0;
    case 1:
      return left;
    case 2:
      return above;
    case 3:
      return (left + above) >> 1;
    case 4: {
      const sum = left + above - aboveLeft;
      const [a, b, c] = [Math.abs(sum - left), Math.abs(sum - above), Math.abs(sum - aboveLeft)];
      return a <= b && a <= c ? left : b <= c ? above : aboveLeft;
    }
    default:
      throw new Error(`This PNG image has the unknown filter ${filter}.`);
  }
}

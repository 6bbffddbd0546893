// sensor_msgs/Image to pixels of a canvas. Encodings: sensor_msgs/image_encodings.h.
export interface RawImage {
  height: number;
  width: number;
  encoding: string;
  is_bigendian: number;
  step: number;
  data: Uint8Array;
}

/** 40 million pixels are 160 MB on a canvas. */
export const MAX_PIXELS = 40_000_000;

type Fill = (image: RawImage, out: Uint8ClampedArray) => void;

/** `red`, `green` and `blue` are positions in a pixel of `bytes` bytes. `deep`: each has 16 bits; the upper 8 are shown. */
function interleaved(bytes: number, red: number, green: number, blue: number, deep = false): Fill {
  return ({ width, height, step, data, is_bigendian: big }, out) => {
    const scale = deep ? 2 : 1;
    const upper = deep && big === 0 ? 1 : 0;
    const [r, g, b] = [red * scale + upper, green * scale + upper, blue * scale + upper];
    let to = 0;
    for (let y = 0; y < height; y++) {
      let from = y * step;
      for (let x = 0; x < width; x++, from += bytes, to += 4) {
        out[to] = data[from + r] as number;
        out[to + 1] = data[from + g] as number;
        out[to + 2] = data[from + b] as number;
        out[to + 3] = 255;
      }
    }
  };
}

type ReadNumber = (view: DataView, at: number, little: boolean) => number;

/** Numbers wider than a byte become shades of gray from the smallest to the largest in the image; NaN is black. */
function stretched(bytes: 2 | 4 | 8, read: ReadNumber): Fill {
  return ({ width, height, step, data, is_bigendian: big }, out) => {
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    const little = big === 0;
    let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width; x++) {
        const value = read(view, y * step + x * bytes, little);
        if (value < low && value !== Number.NEGATIVE_INFINITY) low = value;
        if (value > high && value !== Number.POSITIVE_INFINITY) high = value;
      }
    const scale = high > low ? 255 / (high - low) : 0;
    let to = 0;
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width; x++, to += 4) {
        const gray = (read(view, y * step + x * bytes, little) - low) * scale;
        out[to] = out[to + 1] = out[to + 2] = gray;
        out[to + 3] = 255;
      }
  };
}

/** ITU-R BT.601, as in OpenCV; cb and cr from -128 to 127. */
function putColor(out: Uint8ClampedArray, to: number, y: number, cb: number, cr: number): void {
  const luma = 1.164 * (y - 16);
  out[to] = luma + 1.596 * cr;
  out[to + 1] = luma - 0.813 * cr - 0.391 * cb;
  out[to + 2] = luma + 2.018 * cb;
  out[to + 3] = 255;
}

/** Two pixels share their color: bytes u y v y (uyvy) or y u y v (yuyv). */
function yuv422(firstY: 0 | 1): Fill {
  const u = 1 - firstY;
  const v = u + 2;
  return ({ width, height, step, data }, out) => {
    let to = 0;
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width; x++, to += 4) {
        const pair = y * step + (x >> 1) * 4;
        const y0 = data[pair + firstY + (x & 1) * 2] as number;
        putColor(out, to, y0, (data[pair + u] as number) - 128, (data[pair + v] as number) - 128);
      }
  };
}

/** All y, then pairs of u and v, or v and u: one pair for 2 x 2 pixels (`shared` 1) or for each pixel (0). */
function planes(firstU: 0 | 1, shared: 0 | 1): Fill {
  return ({ width, height, step, data }, out) => {
    let to = 0;
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width; x++, to += 4) {
        const row = step * height + (y >> shared) * (shared === 1 ? step : 2 * step);
        const pair = row + (x >> shared) * 2;
        const cb = (data[pair + firstU] as number) - 128;
        const cr = (data[pair + 1 - firstU] as number) - 128;
        putColor(out, to, data[y * step + x] as number, cb, cr);
      }
  };
}

/**
 * Colors of the first four cells, row by row: each pixel uses the nearest cells of the other colors.
 * Of cells with 16 bits the upper 8 are shown.
 */
function bayer(pattern: string, bytes: 1 | 2): Fill {
  return ({ width, height, step, data, is_bigendian: big }, out) => {
    const upper = bytes === 2 && big === 0 ? 1 : 0;
    const at = (x: number, y: number) => data[y * step + x * bytes + upper] as number;
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width; x++) {
        // The 2 x 2 block that begins here has each color once, and green twice.
        const x0 = Math.min(x, width - 2);
        const y0 = Math.min(y, height - 2);
        let [r, g, b] = [0, 0, 0];
        for (const [dx, dy] of [
          [0, 0],
          [1, 0],
          [0, 1],
          [1, 1],
        ] as const) {
          const value = at(x0 + dx, y0 + dy);
          const color = pattern[((y0 + dy) & 1) * 2 + ((x0 + dx) & 1)];
          if (color === "r") r = value;
          else if (color === "b") b = value;
          else g += value / 2;
        }
        out.set([r, g, b, 255], (y * width + x) * 4);
      }
  };
}

const UINT16 = stretched(2, (view, at, little) => view.getUint16(at, little));

const ENCODINGS: Readonly<Record<string, readonly [bytes: number, fill: Fill]>> = {
  rgb8: [3, interleaved(3, 0, 1, 2)],
  rgba8: [4, interleaved(4, 0, 1, 2)],
  bgr8: [3, interleaved(3, 2, 1, 0)],
  bgra8: [4, interleaved(4, 2, 1, 0)],
  mono8: [1, interleaved(1, 0, 0, 0)],
  "8UC1": [1, interleaved(1, 0, 0, 0)],
  "8UC3": [3, interleaved(3, 2, 1, 0)],
  "8UC4": [4, interleaved(4, 2, 1, 0)],
  rgb16: [6, interleaved(6, 0, 1, 2, true)],
  rgba16: [8, interleaved(8, 0, 1, 2, true)],
  bgr16: [6, interleaved(6, 2, 1, 0, true)],
  bgra16: [8, interleaved(8, 2, 1, 0, true)],
  "16UC3": [6, interleaved(6, 2, 1, 0, true)],
  mono16: [2, UINT16],
  "16UC1": [2, UINT16],
  "16SC1": [2, stretched(2, (view, at, little) => view.getInt16(at, little))],
  "32SC1": [4, stretched(4, (view, at, little) => view.getInt32(at, little))],
  "32FC1": [4, stretched(4, (view, at, little) => view.getFloat32(at, little))],
  "64FC1": [8, stretched(8, (view, at, little) => view.getFloat64(at, little))],
  yuv422: [2, yuv422(1)],
  uyvy: [2, yuv422(1)],
  yuv422_yuy2: [2, yuv422(0)],
  yuyv: [2, yuv422(0)],
  nv12: [1, planes(0, 1)],
  nv21: [1, planes(1, 1)],
  nv24: [1, planes(0, 0)],
  bayer_rggb8: [1, bayer("rggb", 1)],
  bayer_rggb16: [2, bayer("rggb", 2)],
  bayer_bggr8: [1, bayer("bggr", 1)],
  bayer_bggr16: [2, bayer("bggr", 2)],
  bayer_gbrg8: [1, bayer("gbrg", 1)],
  bayer_gbrg16: [2, bayer("gbrg", 2)],
  bayer_grbg8: [1, bayer("grbg", 1)],
  bayer_grbg16: [2, bayer("grbg", 2)],
};

/** Two pixels side by side share their color. */
const EVEN_WIDTH = /yuv|uyvy|yuyv|nv12|nv21/;

/** The encoding for an error text; a faulty publisher may write anything. */
function shownEncoding(encoding: string): string {
  return encoding.slice(0, 40) || '""';
}

/**
 * Converts to red, green, blue and alpha.
 *
 * @returns width * height * 4 bytes.
 * @throws Error with a sentence when the image cannot be shown.
 */
export function toRgba(image: RawImage): Uint8ClampedArray<ArrayBuffer> {
  const { width, height, step, data, encoding } = image;
  const known = ENCODINGS[encoding];
  if (known === undefined)
    throw new Error(`Images with the encoding ${shownEncoding(encoding)} cannot be shown.`);
  const [bytes, fill] = known;
  if (width * height > MAX_PIXELS) throw new Error(`An image of ${width} x ${height} is too large to show.`);
  if (width < 1 || height < 1) throw new Error("This image has no pixels.");
  if (step < width * bytes)
    throw new Error(
      `The rows of this ${encoding} image have ${step} bytes; ${width} pixels need ${width * bytes}.`,
    );
  const chromaRows = encoding === "nv24" ? 2 * height : encoding.startsWith("nv") ? Math.ceil(height / 2) : 0;
  if (step * (height + chromaRows - 1) + width * bytes > data.length)
    throw new Error(`A ${encoding} image of ${width} x ${height} needs more than ${data.length} bytes.`);
  if (encoding.startsWith("bayer") && (width < 2 || height < 2)) throw new Error("This image is too small.");
  if (EVEN_WIDTH.test(encoding) && width % 2 === 1)
    throw new Error(`A ${encoding} image must have an even width.`);
  const out = new Uint8ClampedArray(width * height * 4);
  fill(image, out);
  return out;
}

// Depth as compressed_depth_image_transport sends it: a header, then a 16-bit grayscale PNG.
import { decodeGray16 } from "./gray_png.ts";
import type { RawImage } from "./raw_image.ts";

/** int32 kind of compression, float32 a, float32 b. */
const HEADER_BYTES = 12;

export function isCompressedDepth(format: string): boolean {
  return format.includes("compressedDepth");
}

/**
 * Decodes the image of a message.
 *
 * @param format of the message, such as "32FC1; compressedDepth png".
 * @returns depths in millimeters (encoding 16UC1) or in meters (encoding 32FC1).
 * @throws Error with a sentence when it cannot be shown.
 */
export async function decodeDepth(format: string, data: Uint8Array<ArrayBuffer>): Promise<RawImage> {
  if (format.includes("rvl"))
    throw new Error("Depth that is compressed with RVL cannot be shown. Send it as PNG.");
  const picture = await decodeGray16(data.subarray(HEADER_BYTES));
  if (picture === undefined) throw new Error("This compressedDepth image contains no 16-bit grayscale PNG.");
  if (!format.startsWith("32FC1")) return picture;
  const header = new DataView(data.buffer, data.byteOffset, HEADER_BYTES);
  const [a, b] = [header.getFloat32(4, true), header.getFloat32(8, true)];
  const steps = new DataView(picture.data.buffer);
  // The step 0 is a missing measurement.
  const meters = Float32Array.from({ length: picture.width * picture.height }, (_, at) => {
    const step = steps.getUint16(2 * at);
    return step === 0 ? Number.NaN : a / (step - b);
  });
  return {
    ...picture,
    encoding: "32FC1",
    step: 4 * picture.width,
    // Typed arrays have the byte order of the machine, which is little endian wherever browsers run.
    is_bigendian: 0,
    data: new Uint8Array(meters.buffer),
  };
}

// Colors of values, and colors of messages as amounts of light.

/** Writes the color of a value from 0 to 1, blue over green to red ("turbo", approximated), as components from 0 to 1. */
export function rainbow(share: number, out: Float32Array, at: number): void {
  const s = share < 0 ? 0 : Math.min(share, 1);
  out[at] = clamp(1.5 - Math.abs(4 * s - 3));
  out[at + 1] = clamp(1.5 - Math.abs(4 * s - 2));
  out[at + 2] = clamp(1.5 - Math.abs(4 * s - 1));
}

/** Converts one component of a color (0 to 1) from sRGB, as in messages, to linear light, as in the scene. */
export function toLinear(shown: number): number {
  return shown <= 0.04045 ? shown / 12.92 : ((shown + 0.055) / 1.055) ** 2.4;
}

/** The linear light of each component of 8 bits. */
export const LINEAR: ArrayLike<number> = Float32Array.from({ length: 256 }, (_, byte) =>
  toLinear(byte / 255),
);

function clamp(value: number): number {
  return value < 0 ? 0 : Math.min(value, 1);
}

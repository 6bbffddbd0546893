// Colours of values.
/** Red, green and blue (0 to 1) of a share from 0 to 1: blue over green to red ("turbo", approximated). */
export function rainbow(share: number, out: Float32Array, at: number): void {
  const s = share < 0 ? 0 : Math.min(share, 1);
  out[at] = clamp(1.5 - Math.abs(4 * s - 3));
  out[at + 1] = clamp(1.5 - Math.abs(4 * s - 2));
  out[at + 2] = clamp(1.5 - Math.abs(4 * s - 1));
}

function clamp(value: number): number {
  return value < 0 ? 0 : Math.min(value, 1);
}

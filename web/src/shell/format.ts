// Numbers as people read them.

/** A number with at most `digits` significant digits, without trailing zeros. */
export function formatNumber(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return String(value);
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(Math.max(0, digits - 2)).replace(/\.?0+e/, "e");
  return value
    .toPrecision(digits)
    .replace(/(\.\d*?)0+$/, "$1")
    .replace(/\.$/, "");
}

/** A number that changes continuously; the width depends only on the number's size, so that the text does not jump. */
export function formatFixed(value: number): string {
  const size = Math.abs(value);
  if (Number.isInteger(value) || !Number.isFinite(value) || size >= 1e6) return formatNumber(value);
  if (size > 0 && size < 5e-4) return value.toExponential(1);
  return value.toFixed(size >= 1000 ? 1 : size >= 100 ? 2 : 3);
}

export function formatRate(hertz: number): string {
  if (hertz <= 0) return "–";
  return `${hertz >= 100 ? hertz.toFixed(0) : hertz >= 10 ? hertz.toFixed(1) : hertz.toFixed(2)} Hz`;
}

export function formatBytes(bytes: number): string {
  if (bytes < 1000) return `${bytes.toFixed(0)} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toPrecision(3)} kB`;
  return `${(bytes / 1e6).toPrecision(3)} MB`;
}

export function formatBandwidth(bytesPerSecond: number): string {
  return bytesPerSecond > 0 ? `${formatBytes(bytesPerSecond)}/s` : "–";
}

export function formatDuration(seconds: number): string {
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 120) return `${seconds.toFixed(0)} s`;
  if (seconds < 7200) return `${(seconds / 60).toFixed(0)} min`;
  return `${(seconds / 3600).toFixed(0)} h`;
}

const collator = new Intl.Collator("en", { numeric: true });

/** The natural order of names: range_2 before range_10. */
export function compareNames(a: string, b: string): number {
  return collator.compare(a, b);
}

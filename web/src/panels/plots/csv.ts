// The data of a plot as a table: one row for each time, one column for each series.
import type { Series } from "../../plot/series.ts";

/** Returns the text of a CSV file with the values between two times; times are seconds since 1970. */
export function toCsv(series: readonly Series[], fromS: number, toS: number): string {
  const lines = [
    ["time", ...series.map((each) => quoted(each.unit ? `${each.id} [${each.unit}]` : each.id))].join(","),
  ];
  const at = series.map((each) => each.buffer.indexAt(fromS));
  for (;;) {
    let time = Number.POSITIVE_INFINITY;
    series.forEach(({ buffer }, index) => {
      if (at[index]! < buffer.length) time = Math.min(time, buffer.time(at[index]!));
    });
    if (time > toS) break;
    const cells = series.map(({ buffer }, index) => {
      const position = at[index]!;
      if (position >= buffer.length || buffer.time(position) !== time) return "";
      at[index] = position + 1;
      const value = buffer.value(position);
      // A gap has the time of the value before it.
      return Number.isNaN(value) ? "" : String(value);
    });
    if (cells.some((each) => each !== "")) lines.push([time.toFixed(6), ...cells].join(","));
  }
  return `${lines.join("\n")}\n`;
}

function quoted(text: string): string {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

// Reads the values that the user types into fields, and formats values for fields.

import { texts } from "../texts.ts";
import type { Node, Primitive } from "../wire/schema.ts";
import type { Stamp } from "../wire/stamp.ts";

const LIMITS: Readonly<Record<string, readonly [bigint, bigint]>> = {
  int8: [-128n, 127n],
  uint8: [0n, 255n],
  int16: [-32768n, 32767n],
  uint16: [0n, 65535n],
  int32: [-(2n ** 31n), 2n ** 31n - 1n],
  uint32: [0n, 2n ** 32n - 1n],
  int64: [-(2n ** 63n), 2n ** 63n - 1n],
  uint64: [0n, 2n ** 64n - 1n],
};

const BILLION = 1_000_000_000n;

/** The lowest and highest number of an integer type; undefined for floats. */
export function limitsOf(type: Primitive): readonly [number, number] | undefined {
  const limits = LIMITS[type];
  return limits && [Number(limits[0]), Number(limits[1])];
}

/** Reads one number; a string is the error text. An empty field is 0. */
export function parseNumber(type: Primitive, text: string): number | bigint | string {
  const trimmed = text.trim().replace(",", ".");
  const limits = LIMITS[type];
  if (limits === undefined) {
    const value = { nan: Number.NaN, inf: Number.POSITIVE_INFINITY, "-inf": Number.NEGATIVE_INFINITY }[
      trimmed.toLowerCase()
    ];
    if (value !== undefined) return value;
    return Number.isFinite(Number(trimmed)) ? Number(trimmed) : texts.forms.number;
  }
  const [, sign, digits] = /^([+-]?)(\d{1,20}|0x[0-9a-fA-F]{1,16})$/.exec(trimmed || "0") ?? [];
  if (digits === undefined) return texts.forms.integer;
  const whole = BigInt(digits) * (sign === "-" ? -1n : 1n);
  const [low, high] = limits;
  if (whole < low || whole > high) return texts.forms.range(String(low), String(high));
  return type.endsWith("64") ? whole : Number(whole);
}

/** Reads a time or a duration in seconds, to the nanosecond; a string is the error text. */
export function parseStamp(kind: "time" | "duration", text: string): Stamp | string {
  const [, sign, whole, fraction = ""] =
    /^([+-]?)(\d{1,12})(?:[.,](\d{0,9}))?$/.exec(text.trim() || "0") ?? [];
  if (whole === undefined) return texts.forms.seconds;
  const ns = (BigInt(whole) * BILLION + BigInt(fraction.padEnd(9, "0"))) * (sign === "-" ? -1n : 1n);
  const nsec = ((ns % BILLION) + BILLION) % BILLION;
  const sec = (ns - nsec) / BILLION;
  const [low, high] = LIMITS[kind === "time" ? "uint32" : "int32"]!;
  if (sec < low || sec > high) return texts.forms.range(String(low), String(high));
  return { sec: Number(sec), nsec: Number(nsec) };
}

/** The text of a time or a duration for a field. */
export function formatStamp({ sec, nsec }: Stamp): string {
  const ns = BigInt(sec) * BILLION + BigInt(nsec);
  const size = ns < 0n ? -ns : ns;
  const fraction = String(size % BILLION)
    .padStart(9, "0")
    .replace(/0+$/, "");
  return `${ns < 0n ? "-" : ""}${size / BILLION}${fraction && `.${fraction}`}`;
}

/** Reads a list of values separated by commas; a string is the error text. */
export function parseList(element: Node, text: string): unknown[] | string {
  if (element.kind === "string") return parseTexts(text);
  const parts =
    text.trim() === ""
      ? []
      : text
          .replace(/^\[|\]$/g, "")
          .split(",")
          .map((each) => each.trim());
  if (element.kind !== "primitive") return texts.forms.noList;
  const values: unknown[] = [];
  for (const part of parts) {
    if (element.type === "bool") {
      if (!/^(true|false|0|1)$/i.test(part)) return texts.forms.bool;
      values.push(/^(true|1)$/i.test(part));
      continue;
    }
    const value = parseNumber(element.type, part);
    if (typeof value === "string") return value;
    values.push(value);
  }
  return values;
}

/** Reads texts separated by commas; a text with a comma is in quotes, as in `"a, b", c`. */
function parseTexts(text: string): string[] | string {
  const inner = text.trim().replace(/^\[(.*)\]$/s, "$1");
  const found: string[] = [];
  const part = /\s*(?:("(?:[^"\\]|\\.)*")|([^,"]*))\s*(,|$)/y;
  while (inner !== "") {
    const [, quoted, plain = "", end] = part.exec(inner) ?? [];
    if (end === undefined) return texts.forms.quotes;
    try {
      found.push(quoted === undefined ? plain.trim() : (JSON.parse(quoted) as string));
    } catch {
      return texts.forms.quotes;
    }
    if (end === "") break;
  }
  return found;
}

/** The text of a list for its field. */
export function formatList(values: readonly unknown[]): string {
  const isPlain = (text: string) => text === text.trim() && text !== "" && !/[,"\\[\]\n]/.test(text);
  return values
    .map((each) => (typeof each !== "string" || isPlain(each) ? String(each) : JSON.stringify(each)))
    .join(", ");
}

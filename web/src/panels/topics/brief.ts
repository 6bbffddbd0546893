// A message in one short line: its values without the header.
import { formatNumber } from "../../shell/format.ts";
import type { Message, Value } from "../../wire/decode.ts";

const MAX_CHARACTERS = 120;

/** `paths` are the fields to show (default: all except the header). */
export function brief(message: Message, paths?: readonly string[]): string {
  if (paths)
    return briefFields(
      paths.map((path) => [path.replaceAll("_", " "), valueAt(message, path)]),
      ", ",
    );
  const fields = Object.entries(message).filter(([name]) => name !== "header");
  const only = fields.length === 1 ? fields[0] : undefined;
  return only ? briefValue(only[1]) : briefFields(fields);
}

function valueAt(message: Message, path: string): Value {
  let value: Value | undefined = message;
  for (const step of path.split(/[.[\]]+/).filter(Boolean)) value = (value as Message | undefined)?.[step];
  return value ?? "–";
}

function briefFields(fields: [string, Value][], separator = " "): string {
  let text = "";
  for (const [name, value] of fields) {
    text += `${text && separator}${name}: ${briefValue(value)}`;
    if (text.length > MAX_CHARACTERS) break;
  }
  return shortened(text);
}

function shortened(text: string): string {
  return text.length > MAX_CHARACTERS ? `${text.slice(0, MAX_CHARACTERS)}…` : text;
}

export function briefValue(value: Value): string {
  if (typeof value === "number") return formatNumber(value);
  if (typeof value === "string") return shortened(value);
  if (typeof value !== "object") return String(value);
  if (Array.isArray(value) || ArrayBuffer.isView(value)) {
    const list = value as ArrayLike<Value>;
    const first: string[] = [];
    for (let index = 0; index < Math.min(list.length, 6); index++) first.push(briefValue(list[index]!));
    return `[${first.join(", ")}${list.length > 6 ? `, … ${list.length}` : ""}]`;
  }
  if (isStamp(value)) return `${(value.sec + value.nsec / 1e9).toFixed(3)} s`;
  return `{${briefFields(Object.entries(value))}}`;
}

export function isStamp(value: Value): value is { sec: number; nsec: number } {
  return (
    typeof value === "object" &&
    "sec" in value &&
    "nsec" in value &&
    typeof value.sec === "number" &&
    Object.keys(value).length === 2
  );
}

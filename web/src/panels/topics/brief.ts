// A message in one short line: its values without the header.
import { formatNumber } from "../../shell/format.ts";
import type { Message, Value } from "../../wire/decode.ts";

const MAX_CHARACTERS = 120;

export function brief(message: Message): string {
  const fields = Object.entries(message).filter(([name]) => name !== "header");
  const only = fields.length === 1 ? fields[0] : undefined;
  return only ? briefValue(only[1]) : briefFields(fields);
}

function briefFields(fields: [string, Value][]): string {
  let text = "";
  for (const [name, value] of fields) {
    text += `${text && " "}${name}: ${briefValue(value)}`;
    if (text.length > MAX_CHARACTERS) break;
  }
  return text.slice(0, MAX_CHARACTERS);
}

export function briefValue(value: Value): string {
  if (typeof value === "number") return formatNumber(value);
  if (typeof value === "string")
    return value.length > MAX_CHARACTERS ? `${value.slice(0, MAX_CHARACTERS)}…` : value;
  if (typeof value !== "object") return String(value);
  if (Array.isArray(value) || ArrayBuffer.isView(value)) {
    const list = value as ArrayLike<Value>;
    const first: string[] = [];
    for (let index = 0; index < Math.min(list.length, 6); index++) first.push(briefValue(list[index]!));
    return `[${first.join(", ")}${list.length > 6 ? `, … ${list.length}` : ""}]`;
  }
  if (isStamp(value)) return `${value.sec}.${String(value.nsec).padStart(9, "0").slice(0, 3)} s`;
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

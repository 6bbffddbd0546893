// A board's status, from its node's messages on /diagnostics once a second.
import type { Message } from "../../wire/decode.ts";

// How the bridge ends the name of a board's status.
const SUFFIX = ": rosserial";

export interface Endpoint {
  role: string;
  topic: string;
  type: string;
  hertz: number;
  dropped: number;
  bufferBytes: number | undefined;
}

export interface Finding {
  code: string;
  /** The observation, as text. */
  seen: string;
  /** The next step. */
  action: string;
}

export interface BoardStatus {
  name: string;
  /** 0 is healthy, 1 a warning, 2 an error. */
  level: number;
  message: string;
  values: ReadonlyMap<string, string>;
  endpoints: Endpoint[];
  findings: Finding[];
}

/** Returns the boards' statuses in a DiagnosticArray; other nodes' statuses are omitted. */
export function boardStatuses(array: Message): BoardStatus[] {
  const found: BoardStatus[] = [];
  for (const each of (array.status ?? []) as Message[]) {
    const name = String(each.name);
    if (!name.endsWith(SUFFIX)) continue;
    const values = new Map<string, string>();
    for (const { key, value } of each.values as Message[]) values.set(String(key), String(value));
    found.push({
      name: name.slice(0, -SUFFIX.length),
      level: Number(each.level),
      message: String(each.message),
      values,
      endpoints: endpoints(values),
      findings: findings(values),
    });
  }
  return found;
}

/** A value as a number, undefined when it is missing or "unknown". */
export function numberOf(values: ReadonlyMap<string, string>, key: string): number | undefined {
  const text = values.get(key);
  const value = text === undefined || text === "" ? Number.NaN : Number(text);
  return Number.isFinite(value) ? value : undefined;
}

function endpoints(values: ReadonlyMap<string, string>): Endpoint[] {
  const found: Endpoint[] = [];
  for (const [key, type] of values) {
    const match = /^(publisher|subscriber|service server|service client) (\S+) type$/.exec(key);
    if (!match) continue;
    const [, role, topic] = match as unknown as [string, string, string];
    const number = (what: string) => numberOf(values, `${role} ${topic} ${what}`);
    found.push({
      role,
      topic,
      type,
      hertz: number("[Hz]") ?? 0,
      dropped: number("dropped") ?? 0,
      bufferBytes: number("buffer [bytes]"),
    });
  }
  return found;
}

function findings(values: ReadonlyMap<string, string>): Finding[] {
  const found: Finding[] = [];
  for (const [key, text] of values) {
    if (!key.startsWith("finding ")) continue;
    const end = text.lastIndexOf("; ");
    const [seen, action] = end < 0 ? [text, ""] : [text.slice(0, end), text.slice(end + 2)];
    found.push({ code: key.slice("finding ".length), seen, action });
  }
  return found;
}

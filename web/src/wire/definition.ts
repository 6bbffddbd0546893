// Parses the definition of a ROS 1 message with all its parts, as a publisher sends it (`gendeps --cat`).
import type { Constant, Field, Node, Primitive, StructNode } from "./schema.ts";

// Definitions come from peers, so their size and nesting are bounded.
const MAX_CHARACTERS = 1 << 20;
const MAX_FIELDS = 20_000;
const MAX_DEPTH = 32;
const MAX_FIXED_LENGTH = 1 << 24;
// The limit of values in the fixed part of a message: nested fixed arrays multiply.
const MAX_FIXED_VALUES = 1 << 24;

const PRIMITIVES: Record<string, Node> = {
  string: { kind: "string" },
  time: { kind: "time" },
  duration: { kind: "duration" },
  // Older names of these types in ROS 1.
  byte: { kind: "primitive", type: "int8" },
  char: { kind: "primitive", type: "uint8" },
};
for (const type of "bool int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split(" ")) {
  PRIMITIVES[type] = { kind: "primitive", type: type as Primitive };
}

const FIELD = /^([A-Za-z][\w/]*)(\[(\d*)\])?\s+([A-Za-z]\w*)$/;
const CONSTANT = /^([a-z]\w*)\s+([A-Za-z]\w*)\s*=(.*)$/;

/** A definition that cannot be read; the message is the reason. */
export class DefinitionError extends Error {}

interface RawField {
  type: string;
  isArray: boolean;
  length: number | undefined;
  name: string;
  comment: string;
}
interface RawType {
  fields: RawField[];
  constants: Constant[];
}

/** Returns the tree of the type `name`; throws DefinitionError with the reason. */
export function parseDefinition(name: string, text: string): StructNode {
  if (text.length > MAX_CHARACTERS) {
    throw new DefinitionError(
      `the definition of ${name} has ${text.length} characters, more than ${MAX_CHARACTERS}`,
    );
  }
  const raw = new Map<string, RawType>();
  const short = new Map<string, string | undefined>();
  let fieldCount = 0;
  for (const [index, section] of text.split(/^={40,}\s*$/m).entries()) {
    const [head, body] = index === 0 ? [name, section] : splitHead(section);
    const full = shortened(head);
    if (raw.has(full)) continue;
    const parsed = parseBody(full, body);
    fieldCount += parsed.fields.length;
    if (fieldCount > MAX_FIELDS) throw new DefinitionError(`${name} has more than ${MAX_FIELDS} fields`);
    raw.set(full, parsed);
    const last = full.slice(full.lastIndexOf("/") + 1);
    // A name that two packages have is found only with its package.
    short.set(last, short.has(last) ? undefined : full);
  }
  const built = new Map<string, { node: StructNode; values: number; depth: number }>();
  const open = new Set<string>();

  function build(full: string): { node: StructNode; values: number; depth: number } {
    const known = built.get(full);
    if (known) return known;
    if (open.has(full)) throw new DefinitionError(`${full} contains itself`);
    if (open.size >= MAX_DEPTH) throw new DefinitionError(`${name} is nested deeper than ${MAX_DEPTH} types`);
    open.add(full);
    const { fields: rawFields, constants } = raw.get(full)!;
    const fields: Field[] = [];
    let values = 1;
    let depth = 0;
    for (const each of rawFields) {
      let node: Node | undefined = Object.hasOwn(PRIMITIVES, each.type) ? PRIMITIVES[each.type] : undefined;
      let inner = 1;
      if (!node) {
        const part = build(resolve(each.type, full));
        node = part.node;
        inner = part.values;
        depth = Math.max(depth, part.depth);
      }
      if (each.isArray) {
        node = { kind: "array", element: node, length: each.length };
        inner = 1 + inner * (each.length ?? 0);
      }
      values += inner;
      if (values > MAX_FIXED_VALUES)
        throw new DefinitionError(`${full} has more than ${MAX_FIXED_VALUES} values`);
      fields.push({ name: each.name, node, comment: each.comment });
    }
    open.delete(full);
    const result = {
      node: { kind: "struct" as const, name: full, fields, constants },
      values,
      depth: depth + 1,
    };
    if (result.depth > MAX_DEPTH)
      throw new DefinitionError(`${name} is nested deeper than ${MAX_DEPTH} types`);
    built.set(full, result);
    return result;
  }

  function resolve(type: string, from: string): string {
    const wanted = shortened(type);
    const own = `${from.slice(0, from.lastIndexOf("/") + 1)}${wanted}`;
    const header = wanted === "Header" && raw.has("std_msgs/Header") ? "std_msgs/Header" : undefined;
    const found = wanted.includes("/")
      ? raw.has(wanted) && wanted
      : (header ?? (raw.has(own) ? own : short.get(wanted)));
    if (!found) throw new DefinitionError(`the definition of ${name} does not define ${type.slice(0, 80)}`);
    return found;
  }

  return build(shortened(name)).node;
}

function shortened(name: string): string {
  const parts = name.split("/");
  return parts.length === 3 && parts[1] === "msg" ? `${parts[0]}/${parts[2]}` : name;
}

function splitHead(section: string): [string, string] {
  const match = /^\s*MSG:\s*(\S+)[^\n]*\n?/.exec(section);
  if (!match) throw new DefinitionError("a part of the definition has no line MSG: PACKAGE/NAME");
  return [match[1]!, section.slice(match[0].length)];
}

function parseBody(name: string, body: string): RawType {
  const fields: RawField[] = [];
  const constants: Constant[] = [];
  const names = new Set<string>();
  let above: string[] = [];
  for (const line of body.split("\n")) {
    const trimmed = line.trim();
    if (trimmed === "" || trimmed.startsWith("#")) {
      // A comment above a field belongs to it, unless an empty line separates them.
      above = trimmed === "" ? [] : [...above.slice(-7), trimmed.replace(/^#+\s*/, "")];
      continue;
    }
    const constant = CONSTANT.exec(trimmed);
    if (constant) {
      const [, type, key, rest] = constant as unknown as [string, string, string, string];
      const value = type === "string" ? rest.trim() : rest.replace(/#.*/, "").trim();
      constants.push({ name: key, type, value });
      above = [];
      continue;
    }
    const hash = trimmed.indexOf("#");
    const comment = hash < 0 ? "" : trimmed.slice(hash + 1).trim();
    const field = FIELD.exec(hash < 0 ? trimmed : trimmed.slice(0, hash).trim());
    if (!field) throw new DefinitionError(`${name} has a line that is not a field: ${trimmed.slice(0, 80)}`);
    const [, type, brackets, count, key] = field as unknown as [
      string,
      string,
      string | undefined,
      string,
      string,
    ];
    if (names.has(key)) throw new DefinitionError(`${name} has two fields ${key.slice(0, 80)}`);
    const length = count ? Number(count) : undefined;
    if (length !== undefined && length > MAX_FIXED_LENGTH) {
      throw new DefinitionError(`${name}.${key.slice(0, 80)} has more than ${MAX_FIXED_LENGTH} elements`);
    }
    names.add(key);
    fields.push({
      type,
      isArray: brackets !== undefined,
      length,
      name: key,
      comment: comment || above.join(" "),
    });
    above = [];
  }
  return { fields, constants };
}

// The constants of a definition as choices for its fields. Definitions do not name the field of a constant.
import type { Field, Primitive, StructNode } from "../wire/schema.ts";
import { parseNumber } from "./numbers.ts";

export interface Choice {
  name: string;
  value: unknown;
}

const INTEGER = /^u?int\d+$/;
// Older names of integers in ROS 1.
const OLDER_NAMES: Readonly<Record<string, Primitive>> = { byte: "int8", char: "uint8" };

/**
 * The constants for a field: those whose names begin with the field's name, as in BatteryState. If there are none,
 * those of the field's type, if no other field can have them, as in Range.
 */
export function choicesOf(type: StructNode, field: Field): Choice[] {
  const of = typeOf(field);
  if (of === undefined) return [];
  const isPrefixed = (name: string, one: Field) => name.startsWith(`${one.name.toUpperCase()}_`);
  const named = type.constants.filter((each) => isPrefixed(each.name, field));
  // The field's name is beside them already.
  const rest = (name: string) => name.slice(field.name.length + 1);
  if (named.length > 0) return named.flatMap(({ name, value }) => choice(of, rest(name), value));
  if (type.fields.some((each) => each !== field && typeOf(each) === of)) return [];
  return type.constants
    .filter((each) => (OLDER_NAMES[each.type] ?? each.type) === of)
    .filter((each) => !type.fields.some((one) => isPrefixed(each.name, one)))
    .flatMap(({ name, value }) => choice(of, name, value));
}

/** The type of a field that can have choices: an integer or a text. */
function typeOf({ node }: Field): Primitive | "string" | undefined {
  if (node.kind === "string") return "string";
  return node.kind === "primitive" && INTEGER.test(node.type) ? node.type : undefined;
}

function choice(type: Primitive | "string", name: string, text: string): Choice[] {
  const value = type === "string" ? text : parseNumber(type, text);
  // A constant whose value does not fit belongs to another field.
  return type !== "string" && typeof value === "string" ? [] : [{ name, value }];
}

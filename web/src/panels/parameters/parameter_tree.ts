// Parameters as a tree, by the parts of their names.
import { parseExact, stringifyExact } from "../../connection/exact_json.ts";
import type { Parameter } from "../../connection/protocol.ts";

export interface Branch {
  readonly name: string;
  readonly path: string;
  readonly branches: Branch[];
  readonly parameters: { name: string; parameter: Parameter }[];
}

/** Groups `/a/b` and ROS 2's `node.a.b` under their first parts. */
export function parameterTree(parameters: Iterable<Parameter>, search: string): Branch {
  const root: Branch = { name: "", path: "", branches: [], parameters: [] };
  const wanted = search.toLowerCase();
  const sorted = [...parameters].sort((a, b) => (a.name < b.name ? -1 : 1));
  for (const parameter of sorted) {
    if (wanted !== "" && !parameter.name.toLowerCase().includes(wanted)) continue;
    const parts = parameter.name.split(/[/.]/).filter((part) => part !== "");
    const name = parts.pop() ?? parameter.name;
    let branch = root;
    for (const part of parts) {
      let next = branch.branches.find((each) => each.name === part);
      if (next === undefined) {
        next = { name: part, path: `${branch.path}/${part}`, branches: [], parameters: [] };
        branch.branches.push(next);
      }
      branch = next;
    }
    branch.parameters.push({ name, parameter });
  }
  return root;
}

/** The value as a person edits it. */
export function valueText(value: unknown): string {
  return typeof value === "string" ? value : stringifyExact(value);
}

/**
 * Reads the user's input as a value of the parameter's type.
 *
 * @throws Error with a sentence when the text does not fit.
 */
export function readValue(text: string, before: unknown): unknown {
  if (typeof before === "string") return text;
  let value: unknown;
  try {
    value = parseExact(text.trim());
  } catch {
    throw new Error(
      kindOf(before) === "a number" ? "Type a number." : "Type a value as JSON, such as [1, 2] or true.",
    );
  }
  if (before !== undefined && before !== null && kindOf(value) !== kindOf(before))
    throw new Error(`This parameter is ${kindOf(before)}; ${text.slice(0, 40)} is ${kindOf(value)}.`);
  if (hasInfinity(value)) throw new Error("A number is too large.");
  return value;
}

/** Whether a value has a number such as 1e400, which JSON would turn into null: the parameter would be deleted. */
function hasInfinity(value: unknown): boolean {
  if (typeof value === "object" && value !== null) return Object.values(value).some(hasInfinity);
  return value === Number.POSITIVE_INFINITY || value === Number.NEGATIVE_INFINITY;
}

function kindOf(value: unknown): string {
  if (Array.isArray(value)) return "a list";
  if (typeof value === "object") return "a group of values";
  return (
    { number: "a number", bigint: "a number", boolean: "true or false", string: "text" }[
      typeof value as string
    ] ?? "nothing"
  );
}

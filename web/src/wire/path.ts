// Reads the numbers at one path of a message, such as `angular_velocity.z`, `ranges[3]` or `ranges[:]`, without decoding the rest.
import { Cursor, type NumberArray, numberArray, skipper } from "./decode.ts";
import {
  fixedSize,
  type Node,
  PRIMITIVE_BYTES,
  type Primitive,
  type StampNode,
  type StructNode,
  smallestSize,
} from "./schema.ts";

/** The type does not have this path, or it is not a number; the message is the reason. */
export class PathError extends Error {}

export interface PathReader {
  /** Whether the path names many numbers (`[:]`). */
  isArray: boolean;
  /** Whether the number is a bool. */
  isFlag: boolean;
  /** The comment of the field in the definition. */
  comment: string;
  /** Returns the number, NaN where the message is too short or has no such element. */
  read(payload: Uint8Array): number;
  /** Returns the numbers of a path with `[:]`. */
  readAll(payload: Uint8Array): NumberArray | number[];
}

type Step = string | number | "[:]";
type ReadNumber = (cursor: Cursor) => number;

const SCALARS: Record<Primitive, (view: DataView, at: number) => number> = {
  bool: (view, at) => (view.getUint8(at) ? 1 : 0),
  int8: (view, at) => view.getInt8(at),
  uint8: (view, at) => view.getUint8(at),
  int16: (view, at) => view.getInt16(at, true),
  uint16: (view, at) => view.getUint16(at, true),
  int32: (view, at) => view.getInt32(at, true),
  uint32: (view, at) => view.getUint32(at, true),
  int64: (view, at) => Number(view.getBigInt64(at, true)),
  uint64: (view, at) => Number(view.getBigUint64(at, true)),
  float32: (view, at) => view.getFloat32(at, true),
  float64: (view, at) => view.getFloat64(at, true),
};

/** Splits `a.b[3].c` into its steps. */
export function parsePath(path: string): Step[] {
  const steps: Step[] = [];
  for (const part of path.split(".")) {
    const match = /^([A-Za-z]\w*)((?:\[(?:\d{1,9}|:)\])*)$/.exec(part);
    if (!match)
      throw new PathError(`"${path.slice(0, 80)}" is not a path such as angular_velocity.z or ranges[3]`);
    steps.push(match[1]!);
    for (const [, index] of match[2]!.matchAll(/\[(\d+|:)\]/g))
      steps.push(index === ":" ? "[:]" : Number(index));
  }
  return steps;
}

/** Compiles the reader of a path; throws PathError. */
export function pathReader(type: StructNode, path: string): PathReader {
  const steps = parsePath(path);
  const moves: Array<number | ((cursor: Cursor) => boolean)> = [];
  let node = type as Node;
  let comment = "";
  const skip = (each: Node) => {
    const size = fixedSize(each);
    if (size === undefined) {
      const over = skipper(each);
      moves.push((cursor) => {
        over(cursor);
        return true;
      });
    } else if (typeof moves.at(-1) === "number") moves[moves.length - 1] = (moves.at(-1) as number) + size;
    else moves.push(size);
  };
  for (const [index, step] of steps.entries()) {
    if (typeof step === "string" && step !== "[:]") {
      if (isStamp(node) && (step === "sec" || step === "nsec")) {
        if (step === "nsec") moves.push(4);
        node = { kind: "primitive", type: node.kind === "time" ? "uint32" : "int32" };
        continue;
      }
      if (node.kind !== "struct") throw new PathError(`${steps[index - 1]} of ${path} has no field ${step}`);
      const struct: StructNode = node;
      const position = struct.fields.findIndex((each) => each.name === step);
      if (position < 0) throw new PathError(`${struct.name} has no field ${step}`);
      for (const each of struct.fields.slice(0, position)) skip(each.node);
      node = struct.fields[position]!.node;
      comment = struct.fields[position]!.comment;
      continue;
    }
    if (node.kind !== "array") throw new PathError(`${String(steps[index - 1])} of ${path} is not an array`);
    if (step === "[:]") {
      if (index !== steps.length - 1) throw new PathError(`[:] must be the end of ${path}`);
      return arrayReader(node, moves, comment, path);
    }
    const { element, length }: { element: Node; length: number | undefined } = node;
    const smallest = smallestSize(element);
    const size = fixedSize(element);
    const skipOne = skipper(element);
    const wanted = step as number;
    if (length !== undefined && wanted >= length)
      throw new PathError(`${path}: there are only ${length} elements`);
    moves.push((cursor) => {
      if (wanted >= (length ?? cursor.count(smallest))) return false;
      if (size !== undefined) cursor.skip(size * wanted);
      else for (let left = wanted; left > 0; left--) skipOne(cursor);
      return true;
    });
    node = element;
  }
  const value = numberOf(node, path);
  return {
    isArray: false,
    isFlag: node.kind === "primitive" && node.type === "bool",
    comment,
    read: guarded(moves, value),
    readAll: (payload) => [guarded(moves, value)(payload)],
  };
}

function isStamp(node: Node): node is StampNode {
  return node.kind === "time" || node.kind === "duration";
}

function numberOf(node: Node, path: string): ReadNumber {
  if (node.kind === "primitive") {
    const size = PRIMITIVE_BYTES[node.type];
    const get = SCALARS[node.type];
    return (cursor) => get(cursor.view, cursor.skip(size));
  }
  if (isStamp(node)) {
    const get = SCALARS[node.kind === "time" ? "uint32" : "int32"];
    return (cursor) => {
      const start = cursor.skip(8);
      return get(cursor.view, start) + get(cursor.view, start + 4) * 1e-9;
    };
  }
  throw new PathError(`${path} is not a number`);
}

function guarded(moves: ReadonlyArray<number | ((cursor: Cursor) => boolean)>, read: ReadNumber) {
  return (payload: Uint8Array): number => {
    try {
      const cursor = new Cursor(payload);
      return move(cursor, moves) ? read(cursor) : Number.NaN;
    } catch {
      return Number.NaN;
    }
  };
}

function move(cursor: Cursor, moves: ReadonlyArray<number | ((cursor: Cursor) => boolean)>): boolean {
  for (const each of moves) {
    if (typeof each === "number") cursor.skip(each);
    else if (!each(cursor)) return false;
  }
  return true;
}

function arrayReader(
  node: Extract<Node, { kind: "array" }>,
  moves: ReadonlyArray<number | ((cursor: Cursor) => boolean)>,
  comment: string,
  path: string,
): PathReader {
  const { element, length } = node;
  if (element.kind !== "primitive") throw new PathError(`${path} is not an array of numbers`);
  const size = PRIMITIVE_BYTES[element.type];
  const readAll = (payload: Uint8Array): NumberArray | number[] => {
    try {
      const cursor = new Cursor(payload);
      if (!move(cursor, moves)) return [];
      return numberArray(cursor, element.type, length ?? cursor.count(size));
    } catch {
      return [];
    }
  };
  return {
    isArray: true,
    isFlag: false,
    comment,
    readAll,
    read: (payload) => Number(readAll(payload)[0] ?? Number.NaN),
  };
}

/** Returns the numeric paths of a type, at most `maxPaths`; arrays of numbers as `name[:]`. */
export function numericPaths(type: StructNode, maxPaths = 200): string[] {
  const paths: string[] = [];
  const visit = (node: Node, path: string) => {
    if (paths.length >= maxPaths) return;
    if (node.kind === "primitive") paths.push(path);
    else if (node.kind === "struct") {
      for (const each of node.fields) {
        if (each.name === "header" && path === "" && each.node.kind === "struct") continue;
        visit(each.node, path ? `${path}.${each.name}` : each.name);
      }
    } else if (node.kind === "array" && node.element.kind === "primitive") paths.push(`${path}[:]`);
  };
  visit(type, "");
  return paths;
}

// The tree of a message type, as the decoder, the encoder and the path reader walk it.

export type Primitive =
  | "bool"
  | "int8"
  | "uint8"
  | "int16"
  | "uint16"
  | "int32"
  | "uint32"
  | "int64"
  | "uint64"
  | "float32"
  | "float64";

export interface PrimitiveNode {
  kind: "primitive";
  type: Primitive;
}
export interface StringNode {
  kind: "string";
}
export interface StampNode {
  kind: "time" | "duration";
}
export interface ArrayNode {
  kind: "array";
  element: Node;
  /** Undefined for an array of variable length: the message has its length. */
  length: number | undefined;
}
export interface StructNode {
  kind: "struct";
  /** Full name, such as `sensor_msgs/Range`. */
  name: string;
  fields: Field[];
  constants: Constant[];
}
export type Node = PrimitiveNode | StringNode | StampNode | ArrayNode | StructNode;

export interface Field {
  name: string;
  node: Node;
  /** The comment on the field's line or above it; units are often here. */
  comment: string;
}
export interface Constant {
  name: string;
  type: string;
  value: string;
}

export const PRIMITIVE_BYTES: Record<Primitive, number> = {
  bool: 1,
  int8: 1,
  uint8: 1,
  int16: 2,
  uint16: 2,
  int32: 4,
  uint32: 4,
  int64: 8,
  uint64: 8,
  float32: 4,
  float64: 8,
};

/** The fixed size of a node in bytes, undefined when it depends on the message. */
export function fixedSize(node: Node): number | undefined {
  switch (node.kind) {
    case "primitive":
      return PRIMITIVE_BYTES[node.type];
    case "time":
    case "duration":
      return 8;
    case "string":
      return undefined;
    case "array": {
      const element = node.length === undefined ? undefined : fixedSize(node.element);
      return element === undefined ? undefined : element * node.length!;
    }
    case "struct": {
      let sum = 0;
      for (const field of node.fields) {
        const size = fixedSize(field.node);
        if (size === undefined) return undefined;
        sum += size;
      }
      return sum;
    }
  }
}

/** The smallest size of a node in bytes. */
export function smallestSize(node: Node): number {
  if (node.kind === "string") return 4;
  if (node.kind === "array") return node.length === undefined ? 4 : node.length * smallestSize(node.element);
  if (node.kind === "struct") return node.fields.reduce((sum, each) => sum + smallestSize(each.node), 0);
  return fixedSize(node)!;
}

/** The type as a definition writes it, such as `float32[]`. */
export function typeName(node: Node): string {
  switch (node.kind) {
    case "primitive":
      return node.type;
    case "array":
      return `${typeName(node.element)}[${node.length ?? ""}]`;
    case "struct":
      return node.name;
    default:
      return node.kind;
  }
}

// Chooses the control for a topic, from its type and its name.
import { limitsOf } from "../../forms/numbers.ts";
import type { Topic } from "../../store/topics.ts";
import type { Primitive, StructNode } from "../../wire/schema.ts";
import { DRIVE_TYPES } from "../drive/commands.ts";

export type ControlKind =
  | { kind: "button" }
  | { kind: "toggle"; field: string }
  | { kind: "slider"; field: string; type: Primitive; min: number; max: number; step: number }
  | { kind: "servos"; fields: string[]; min: number; max: number; step: number }
  | { kind: "text"; field: string }
  | { kind: "color" }
  | { kind: "joints" }
  | { kind: "drive" }
  | { kind: "form" };

const FLOATS: readonly Primitive[] = ["float32", "float64"];
const SERVO = /servo|angle/i;
/** The name of a message type for servos. `angle` is not enough here: such messages may have radians. */
const SERVOS = /servo[^/]*$/i;
// More sliders are not readable.
const MAX_SERVOS = 12;

export function controlKind(topic: string, type: StructNode): ControlKind {
  if (DRIVE_TYPES.includes(type.name)) return { kind: "drive" };
  if (type.name === "std_msgs/ColorRGBA") return { kind: "color" };
  if (type.name === "sensor_msgs/JointState") return { kind: "joints" };
  const [first, second] = type.fields;
  if (first === undefined) return { kind: "button" };
  if (second !== undefined) return servos(type) ?? { kind: "form" };
  const { name, node } = first;
  if (node.kind === "string") return { kind: "text", field: name };
  if (node.kind !== "primitive") return { kind: "form" };
  if (node.type === "bool") return { kind: "toggle", field: name };
  return { kind: "slider", field: name, type: node.type, ...sliderRange(topic, node.type) };
}

/** Whether the overview shows the control as a card. A form is too large: only the panel of all controls has it. */
export function fitsCard(topic: Topic): boolean {
  try {
    return controlKind(topic.name, topic.type()).kind !== "form";
  } catch {
    return false;
  }
}

/** A message whose type is named after servos, and which has only numbers. */
function servos({ name, fields }: StructNode): ControlKind | undefined {
  const types = fields.flatMap(({ node }) => (node.kind === "primitive" ? [node.type] : []));
  const isNumber = (type: Primitive) => FLOATS.includes(type) || (limitsOf(type) && !type.endsWith("int64"));
  const isNumbers = types.length === fields.length && types.every(isNumber);
  if (!SERVOS.test(name) || !isNumbers || fields.length > MAX_SERVOS) return undefined;
  const range = sliderRange(name, types[0]!);
  return { kind: "servos", fields: fields.map((field) => field.name), ...range };
}

/** Where a slider begins and ends at first; the user can change both. */
function sliderRange(topic: string, type: Primitive): { min: number; max: number; step: number } {
  const isFloat = FLOATS.includes(type);
  // Hobby servos turn by 180 degrees, and Arduino's Servo.write() expects degrees.
  if (SERVO.test(topic))
    return { min: 0, max: Math.min(180, limitsOf(type)?.[1] ?? 180), step: isFloat ? 0.5 : 1 };
  if (isFloat) return { min: -1, max: 1, step: 0.01 };
  const [low, high] = limitsOf(type) as readonly [number, number];
  // analogWrite() accepts 0 to 255; a slider over all of int32 would be unusable.
  return { min: Math.max(low, 0), max: Math.min(high, 255), step: 1 };
}

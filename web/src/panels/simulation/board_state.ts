// The state of a simulated board, published by its node on ~state: JSON in a std_msgs/String.

const STATE = /^(\/.*)_simulation\/state$/;
const PIN = /^(in|out)([01])$|^pwm([\d.]+)$/;

export interface Pin {
  name: string;
  direction: "in" | "out" | "pwm";
  /** 0 or 1; for PWM the duty cycle. */
  level: number;
}

export interface BoardState {
  board: string;
  mcu: string;
  pins: Pin[];
  /** Degrees by pin. */
  servos: Record<string, number>;
  /** The last value of each command, such as `range`: `0.5`. */
  values: Record<string, string>;
  volts: Record<string, number>;
  /** Pins that are driven from outside: 0 or 1. */
  driven: Record<string, number>;
  /** The commands that the board accepts. */
  commands: readonly string[];
  /** The maximum voltage of an analog input. */
  maxVolts: number;
  error: string;
}

/** Whether a pin has a number, such as D13 and A0; the others are not in the drawing. */
export function isNumbered(name: string): boolean {
  return /^[AD]\d+$/.test(name);
}

/** Boards by their state topics: `/sonar` by `/sonar_simulation/state`. */
export function simulatedBoards(topics: Iterable<{ name: string; typeName: string }>): Map<string, string> {
  const boards = new Map<string, string>();
  for (const { name, typeName } of topics) {
    const match = STATE.exec(name);
    if (match && typeName === "std_msgs/String") boards.set(name, match[1]!);
  }
  return boards;
}

/** Reads a state; undefined if it is not one. Any node may publish on the topic. */
export function readBoardState(text: unknown): BoardState | undefined {
  let state: Record<string, unknown>;
  try {
    state = asRecord(JSON.parse(String(text)));
  } catch {
    return undefined;
  }
  const values = asRecord(state.values);
  const pins: Pin[] = [];
  for (const [name, value] of Object.entries(asRecord(state.pins))) {
    const match = PIN.exec(String(value));
    if (match) {
      const direction = (match[1] ?? "pwm") as Pin["direction"];
      pins.push({ name, direction, level: Number(match[2] ?? match[3]) });
    }
  }
  return {
    board: String(state.board),
    mcu: String(state.mcu),
    pins,
    servos: numbers(state.servos),
    values: Object.fromEntries(
      Object.entries(values).filter(([, value]) => typeof value === "string"),
    ) as Record<string, string>,
    volts: numbers(values.adc),
    driven: numbers(values.pin),
    commands: Array.isArray(state.commands) ? state.commands.map(String) : [],
    maxVolts: Number(state.max_volts) || 5,
    error: String(state.error ?? ""),
  };
}

function asRecord(value: unknown): Record<string, unknown> {
  return typeof value === "object" && value !== null ? (value as Record<string, unknown>) : {};
}

function numbers(value: unknown): Record<string, number> {
  const entries = Object.entries(asRecord(value)).map(([key, each]) => [key, Number(each)] as const);
  return Object.fromEntries(entries.filter(([, each]) => Number.isFinite(each)));
}

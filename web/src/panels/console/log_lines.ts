// The last lines of /rosout.

export interface LogLine {
  readonly id: number;
  /** Seconds since 1970. */
  readonly timeS: number;
  readonly level: Level;
  readonly node: string;
  readonly text: string;
  /** The file, the line and the function, if the node reports them. */
  readonly source: string;
}
export type Level = "debug" | "info" | "warning" | "error" | "fatal";
export const LEVELS: readonly Level[] = ["debug", "info", "warning", "error", "fatal"];

// An hour of a robot that logs a lot; the oldest lines are removed first.
const MAX_LINES = 5000;
const MAX_TEXT = 10_000;

interface Log {
  header?: { stamp: { sec: number; nsec: number } };
  stamp?: { sec: number; nsec: number };
  level: number;
  name: string;
  msg: string;
  file: string;
  function: string;
  line: number;
}

/** rosgraph_msgs/Log counts levels in powers of two, rcl_interfaces/Log in tens. */
function levelOf(level: number, isRos2: boolean): Level {
  const index = isRos2 ? level / 10 - 1 : Math.log2(level);
  return LEVELS[Math.max(0, Math.min(4, Math.floor(index)))] ?? "info";
}

export class LogLines {
  lines: LogLine[] = [];
  private nextId = 1;

  /** Adds a message of rosgraph_msgs/Log or rcl_interfaces/Log. */
  add(message: unknown, typeName: string): void {
    const log = message as Log;
    const isRos2 = typeName.startsWith("rcl_interfaces/");
    const stamp = log.header?.stamp ?? log.stamp ?? { sec: 0, nsec: 0 };
    this.lines.push({
      id: this.nextId++,
      timeS: stamp.sec + stamp.nsec * 1e-9,
      level: levelOf(log.level, isRos2),
      node: log.name,
      text: log.msg.slice(0, MAX_TEXT),
      source: log.file ? `${log.file}:${log.line}${log.function ? ` ${log.function}` : ""}` : "",
    });
    if (this.lines.length > MAX_LINES * 1.2) this.lines = this.lines.slice(-MAX_LINES);
  }

  /** The lines of at least this level, from this node ("" for all) and with this text. */
  filtered(minLevel: Level, node: string, search: string): LogLine[] {
    const from = LEVELS.indexOf(minLevel);
    const wanted = search.toLowerCase();
    return this.lines.filter(
      (line) =>
        LEVELS.indexOf(line.level) >= from &&
        (node === "" || line.node === node) &&
        (wanted === "" ||
          line.text.toLowerCase().includes(wanted) ||
          line.node.toLowerCase().includes(wanted)),
    );
  }

  nodes(): string[] {
    return [...new Set(this.lines.map((line) => line.node))].sort();
  }

  clear(): void {
    this.lines = [];
  }
}

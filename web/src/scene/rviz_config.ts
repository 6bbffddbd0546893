// Reads the fixed frame and the displays of a .rviz file.
export interface RvizDisplay {
  /** The class without its package: `LaserScan` for `rviz/LaserScan` and `rviz_default_plugins/LaserScan`. */
  readonly kind: string;
  readonly enabled: boolean;
  readonly topic: string;
}
export interface RvizConfig {
  readonly fixedFrame: string;
  readonly displays: RvizDisplay[];
}

type Tree = { [key: string]: Tree | Tree[] | string };

/** Files of RViz have hundreds of lines. */
const MAX_LINES = 20_000;

/**
 * Reads a configuration of RViz or RViz2.
 *
 * RViz writes one regular form of YAML: two spaces per level, one value per line.
 *
 * @throws Error with a message for the user if the text has a different form.
 */
export function readRvizConfig(text: string): RvizConfig {
  const lines = text.split(/\r?\n/).filter((line) => line.trim() !== "" && !line.trim().startsWith("#"));
  if (lines.length > MAX_LINES) throw new Error("This file is too long for an RViz configuration.");
  const tree = readMap(new Lines(lines), 0);
  const manager = tree["Visualization Manager"];
  if (manager === undefined || typeof manager === "string" || Array.isArray(manager))
    throw new Error("This is not an RViz configuration: it has no Visualization Manager.");
  const displays: RvizDisplay[] = [];
  collect(manager.Displays, displays);
  const options = manager["Global Options"];
  const fixedFrame = isTree(options) ? (options["Fixed Frame"] ?? "") : "";
  return { fixedFrame: typeof fixedFrame === "string" ? fixedFrame : "", displays };
}

function isTree(value: Tree | Tree[] | string | undefined): value is Tree {
  return typeof value === "object" && !Array.isArray(value);
}

function collect(value: Tree | Tree[] | string | undefined, displays: RvizDisplay[]): void {
  if (!Array.isArray(value)) return;
  for (const each of value) {
    const kind = typeof each.Class === "string" ? (each.Class.split("/").at(-1) ?? "") : "";
    // RViz does not show the displays of a disabled group.
    if (kind === "Group" && each.Enabled !== "false") collect(each.Displays, displays);
    // RViz2 nests the topic: Topic: { Value: /scan }.
    const named = isTree(each.Topic)
      ? each.Topic.Value
      : (each.Topic ?? each["Marker Topic"] ?? each["Image Topic"]);
    displays.push({ kind, enabled: each.Enabled !== "false", topic: absolute(named) });
  }
}

/** RViz of ROS 1 writes the topics of markers without the leading slash. */
function absolute(topic: unknown): string {
  if (typeof topic !== "string" || topic === "") return "";
  return topic.startsWith("/") ? topic : `/${topic}`;
}

class Lines {
  private at = 0;
  private readonly lines: string[];

  constructor(lines: string[]) {
    this.lines = lines;
  }

  peek(): { indent: number; text: string } | undefined {
    const line = this.lines[this.at];
    if (line === undefined) return undefined;
    const text = line.trimStart();
    return { indent: line.length - text.length, text };
  }

  next(): void {
    this.at++;
  }

  /** Replaces the dash of a list's item with a space, so that its first key is read like the others. */
  openItem(): void {
    const line = this.lines[this.at] as string;
    this.lines[this.at] = line.replace("-", " ");
  }
}

function readMap(lines: Lines, indent: number): Tree {
  const map: Tree = {};
  for (let line = lines.peek(); line !== undefined; line = lines.peek()) {
    if (line.indent !== indent || line.text.startsWith("- ")) break;
    const colon = line.text.indexOf(":");
    if (colon < 0) throw new Error(`This is not an RViz configuration: ${line.text.slice(0, 60)}`);
    const key = line.text.slice(0, colon);
    const value = line.text.slice(colon + 1).trim();
    lines.next();
    map[key] = value === "" ? readBelow(lines, indent) : unquoted(value);
  }
  const left = lines.peek();
  if (left !== undefined && left.indent > indent)
    throw new Error("This RViz configuration is indented unevenly.");
  return map;
}

function readBelow(lines: Lines, indent: number): Tree | Tree[] | string {
  const line = lines.peek();
  if (line === undefined) return "";
  if (line.text.startsWith("- ") && line.indent >= indent) return readList(lines, line.indent);
  return line.indent > indent ? readMap(lines, line.indent) : "";
}

function readList(lines: Lines, indent: number): Tree[] {
  const items: Tree[] = [];
  for (let line = lines.peek(); line?.indent === indent && line.text.startsWith("- "); line = lines.peek()) {
    if (!line.text.includes(":")) {
      items.push({ "": unquoted(line.text.slice(2)) });
      lines.next();
      continue;
    }
    lines.openItem();
    items.push(readMap(lines, (lines.peek() as { indent: number }).indent));
  }
  return items;
}

function unquoted(value: string): string {
  const quote = value[0];
  return (quote === '"' || quote === "'") && value.at(-1) === quote ? value.slice(1, -1) : value;
}

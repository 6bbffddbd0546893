// Lays out nodes and topics from left to right, as rqt_graph does; where that is too wide, from top to bottom.
import * as dagre from "@dagrejs/dagre";
import { isHidden } from "../../store/topics.ts";
import { texts } from "../../texts.ts";

export interface Box {
  readonly id: string;
  readonly label: string;
  /** The label as it fits into the box. */
  readonly text: string;
  readonly kind: "node" | "topic";
  /** The search text for the list of topics; "" for a box of topics without a common name. */
  readonly search: string;
  /** Whether the box is one topic, which has a rate. */
  readonly isOne: boolean;
  x: number;
  y: number;
  width: number;
  height: number;
}
export interface Edge {
  readonly from: string;
  readonly to: string;
  points: readonly { x: number; y: number }[];
}
export interface Drawing {
  isVertical: boolean;
  boxes: Box[];
  edges: Edge[];
  width: number;
  height: number;
}

export interface GraphInput {
  readonly publishers: ReadonlyMap<string, readonly string[]>;
  readonly subscribers: ReadonlyMap<string, readonly string[]>;
}

/** With more boxes, topics that connect the same nodes are drawn as one box per namespace. */
const MAX_SINGLE_BOXES = 80;
/** With more boxes, the layout takes over a second, and the picture is unreadable. */
export const MAX_BOXES = 400;
const CHARACTER_WIDTH = 7.6;
interface Look {
  readonly isVertical: boolean;
  /** Longer names are shortened in the middle: their ends differ. */
  readonly maxLabel: number;
  /** The space between a node and its topics, in pixels. */
  readonly gap: number;
}
const WIDE: readonly [Look, Look] = [
  { isVertical: false, maxLabel: 36, gap: 56 },
  { isVertical: true, maxLabel: 36, gap: 40 },
];
/** A phone or a narrow window, in pixels. */
const NARROW_WIDTH = 800;
/** Three columns fit on a phone. */
const NARROW: readonly [Look, Look] = [
  { isVertical: false, maxLabel: 16, gap: 28 },
  { isVertical: true, maxLabel: 16, gap: 40 },
];
/** Topics of every node, which hide the others (rqt_graph's "Debug"). */
const PLUMBING = ["/rosout", "/rosout_agg", "/clock", "/parameter_events", "/diagnostics"];

/**
 * Lays out the part of the graph that matches the filter.
 *
 * @param filter part of the name of a node or topic; the neighbors are drawn too.
 * @param withPlumbing whether to draw /rosout and similar topics, and the page's own subscriptions.
 * @param ownNode the gateway's node, which subscribes for the page.
 * @param boxHeight the height of a box, in pixels.
 * @param maxWidth the width in which the drawing should fit, in pixels.
 * @returns undefined when there is more than can be drawn.
 */
export function layout(
  graph: GraphInput,
  filter: string,
  withPlumbing: boolean,
  ownNode = "",
  boxHeight = 30,
  maxWidth = Number.POSITIVE_INFINITY,
): Drawing | undefined {
  const isNarrow = maxWidth < NARROW_WIDTH;
  const place = (boxes: Boxes) => {
    const [right, down] = isNarrow ? NARROW : WIDE;
    const usual = draw(boxes, boxHeight, right);
    // On a phone, the narrower drawing is shown larger.
    if (usual.width <= maxWidth && !isNarrow) return usual;
    const other = draw(boxes, boxHeight, down);
    return other.width < usual.width ? other : usual;
  };
  const pairs: Pair[] = [];
  const add = (table: GraphInput["publishers"], publishes: boolean) => {
    for (const [topic, nodes] of table) {
      if (!withPlumbing && (PLUMBING.includes(topic) || isHidden(topic))) continue;
      for (const node of nodes)
        if (withPlumbing || publishes || node !== ownNode) pairs.push({ node, topic, publishes });
    }
  };
  add(graph.publishers, true);
  add(graph.subscribers, false);
  const text = filter.trim().toLowerCase();
  const wanted = pairs.filter(({ node, topic }) => `${node} ${topic}`.toLowerCase().includes(text));
  const drawing = boxesOf(wanted.map((pair) => ({ ...pair, members: [pair.topic] })));
  if (sizeOf(drawing) <= MAX_SINGLE_BOXES) return place(drawing);
  const byNamespace = boxesOf(
    mergeTopics(wanted, (topic) => topic.slice(0, topic.indexOf("/", 1) + 1) || topic),
  );
  if (sizeOf(byNamespace) <= MAX_BOXES) return place(byNamespace);
  const merged = boxesOf(mergeTopics(wanted, () => ""));
  return sizeOf(merged) <= MAX_BOXES ? place(merged) : undefined;
}

function sizeOf({ nodes, topics }: Boxes): number {
  return nodes.size + topics.size;
}

interface Pair {
  readonly node: string;
  readonly topic: string;
  readonly publishes: boolean;
}
/** `members` are the topics that are drawn as `topic`. */
type Connection = Pair & { readonly members: readonly string[] };

interface Boxes {
  readonly nodes: ReadonlySet<string>;
  readonly topics: ReadonlyMap<string, readonly string[]>;
  readonly pairs: readonly Connection[];
}

function boxesOf(pairs: readonly Connection[]): Boxes {
  return {
    nodes: new Set(pairs.map((each) => each.node)),
    topics: new Map(pairs.map(({ topic, members }) => [topic, members])),
    pairs,
  };
}

/** Draws topics of one family with the same publishers and the same subscribers as one. */
function mergeTopics(pairs: readonly Pair[], familyOf: (topic: string) => string): Connection[] {
  const ends = new Map<string, string[]>();
  for (const { node, topic, publishes } of pairs) {
    const own = ends.get(topic) ?? [];
    own.push(`${publishes ? ">" : "<"}${node}`);
    ends.set(topic, own);
  }
  const groups = new Map<string, string[]>();
  for (const [topic, own] of ends) {
    const key = `${own.sort().join()} ${familyOf(topic)}`;
    groups.set(key, [...(groups.get(key) ?? []), topic]);
  }
  const merged: Connection[] = [];
  for (const members of groups.values()) {
    const topic =
      members.length === 1
        ? (members[0] as string)
        : texts.graph.several(`${commonStart(members)}…`, members.length);
    for (const end of ends.get(members[0] as string) ?? [])
      merged.push({ node: end.slice(1), topic, publishes: end.startsWith(">"), members });
  }
  return merged;
}

function commonStart(names: readonly string[]): string {
  const [first = ""] = names;
  let length = first.length;
  for (const name of names) while (!name.startsWith(first.slice(0, length))) length--;
  return first.slice(0, length);
}

export function shortLabel(name: string, maxLength: number): string {
  if (name.length <= maxLength) return name;
  const half = Math.floor((maxLength - 1) / 2);
  return `${name.slice(0, half)}…${name.slice(-half)}`;
}

function draw({ nodes, topics, pairs }: Boxes, boxHeight: number, look: Look): Drawing {
  const { isVertical, maxLabel, gap } = look;
  const graph = new dagre.graphlib.Graph();
  const rankdir = isVertical ? "TB" : "LR";
  graph.setGraph({ rankdir, nodesep: 14, ranksep: gap, marginx: 12, marginy: 12 });
  graph.setDefaultEdgeLabel(() => ({}));
  const boxes = new Map<string, Box>();
  const addBox = (kind: Box["kind"], label: string, members: readonly string[] = [label]) => {
    const id = `${kind} ${label}`;
    const text = shortLabel(label, maxLabel);
    const named = { id, label, text, kind, search: commonStart(members), isOne: members.length === 1 };
    const box = {
      ...named,
      x: 0,
      y: 0,
      width: text.length * CHARACTER_WIDTH + 24,
      height: boxHeight,
    };
    boxes.set(id, box);
    graph.setNode(id, { width: box.width, height: box.height });
  };
  for (const each of nodes) addBox("node", each);
  for (const [label, members] of topics) addBox("topic", label, members);
  const edges: Edge[] = [];
  for (const { node, topic, publishes } of pairs) {
    const [from, to] = publishes ? [`node ${node}`, `topic ${topic}`] : [`topic ${topic}`, `node ${node}`];
    graph.setEdge(from, to);
    edges.push({ from, to, points: [] });
  }
  dagre.layout(graph);
  let [width, height] = [0, 0];
  for (const box of boxes.values()) {
    const { x, y } = graph.node(box.id) as { x: number; y: number };
    box.x = x;
    box.y = y;
    width = Math.max(width, x + box.width / 2);
    height = Math.max(height, y + box.height / 2);
  }
  for (const edge of edges) {
    const { points } = graph.edge(edge.from, edge.to) as { points: { x: number; y: number }[] };
    edge.points = fromSideToSide(points, boxes.get(edge.from)!, boxes.get(edge.to)!, isVertical);
    for (const { x, y } of points) {
      width = Math.max(width, x);
      height = Math.max(height, y);
    }
  }
  return { isVertical, boxes: [...boxes.values()], edges, width: width + 12, height: height + 12 };
}

/** Moves the ends of an edge to the middle of a side; dagre uses any point on the border. */
function fromSideToSide(points: Edge["points"], from: Box, to: Box, isVertical: boolean): Edge["points"] {
  // An edge against the reading direction leaves to the left, or upwards.
  if (isVertical) {
    const end = from.y <= to.y ? 0.5 : -0.5;
    return [
      { x: from.x, y: from.y + end * from.height },
      ...points.slice(1, -1),
      { x: to.x, y: to.y - end * to.height },
    ];
  }
  const side = from.x <= to.x ? 0.5 : -0.5;
  return [
    { x: from.x + side * from.width, y: from.y },
    ...points.slice(1, -1),
    { x: to.x - side * to.width, y: to.y },
  ];
}

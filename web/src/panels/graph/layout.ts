// Lays out nodes and topics from left to right, as rqt_graph does.
import * as dagre from "@dagrejs/dagre";

export interface Box {
  readonly id: string;
  readonly label: string;
  readonly kind: "node" | "topic";
  x: number;
  y: number;
  width: number;
  height: number;
}
export interface Edge {
  readonly from: string;
  readonly to: string;
  /** The topic that it belongs to. */
  readonly topic: string;
  points: readonly { x: number; y: number }[];
}
export interface Drawing {
  boxes: Box[];
  edges: Edge[];
  width: number;
  height: number;
}

export interface GraphInput {
  readonly publishers: ReadonlyMap<string, readonly string[]>;
  readonly subscribers: ReadonlyMap<string, readonly string[]>;
}

/** More boxes take the layout over a second, and nobody reads them. */
export const MAX_BOXES = 400;
const CHARACTER_WIDTH = 7.2;
/** Topics of every node, which hide what matters (rqt_graph's "Debug"). */
const PLUMBING = ["/rosout", "/rosout_agg", "/clock", "/parameter_events", "/diagnostics"];

/**
 * Lay out what matches.
 *
 * @param filter part of the name of a node or topic; its neighbours are drawn too.
 * @param withPlumbing draw /rosout and its like.
 * @returns undefined when there is more than can be drawn.
 */
export function layout(graph: GraphInput, filter: string, withPlumbing: boolean): Drawing | undefined {
  const pairs: { node: string; topic: string; publishes: boolean }[] = [];
  const add = (table: GraphInput["publishers"], publishes: boolean) => {
    for (const [topic, nodes] of table) {
      if (!withPlumbing && PLUMBING.includes(topic)) continue;
      for (const node of nodes) pairs.push({ node, topic, publishes });
    }
  };
  add(graph.publishers, true);
  add(graph.subscribers, false);
  const wanted = pairs.filter(({ node, topic }) => node.includes(filter) || topic.includes(filter));
  const nodes = new Set(wanted.map((each) => each.node));
  const topics = new Set(wanted.map((each) => each.topic));
  if (nodes.size + topics.size > MAX_BOXES) return undefined;
  return place(nodes, topics, wanted);
}

function place(
  nodes: ReadonlySet<string>,
  topics: ReadonlySet<string>,
  pairs: readonly { node: string; topic: string; publishes: boolean }[],
): Drawing {
  const graph = new dagre.graphlib.Graph();
  graph.setGraph({ rankdir: "LR", nodesep: 14, ranksep: 56, marginx: 12, marginy: 12 });
  graph.setDefaultEdgeLabel(() => ({}));
  const boxes = new Map<string, Box>();
  const addBox = (kind: Box["kind"], label: string) => {
    const id = `${kind} ${label}`;
    const box = { id, label, kind, x: 0, y: 0, width: label.length * CHARACTER_WIDTH + 24, height: 30 };
    boxes.set(id, box);
    graph.setNode(id, { width: box.width, height: box.height });
  };
  for (const each of nodes) addBox("node", each);
  for (const each of topics) addBox("topic", each);
  const edges: Edge[] = [];
  for (const { node, topic, publishes } of pairs) {
    const [from, to] = publishes ? [`node ${node}`, `topic ${topic}`] : [`topic ${topic}`, `node ${node}`];
    graph.setEdge(from, to);
    edges.push({ from, to, topic, points: [] });
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
    edge.points = points;
    for (const { x, y } of points) {
      width = Math.max(width, x);
      height = Math.max(height, y);
    }
  }
  return { boxes: [...boxes.values()], edges, width: width + 12, height: height + 12 };
}

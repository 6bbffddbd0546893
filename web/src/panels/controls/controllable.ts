// Which topics wait for input: a node subscribes, and no other node publishes.
import { hasSubscriber } from "../graph_of.ts";
import type { Graph } from "../panel.ts";

// Subscribed by tools and by every node, not for people.
const NOT_FOR_HANDS =
  /^\/(rosout|rosout_agg|clock|tf|tf_static|diagnostics|parameter_events)$|\/(feedback|status|result|goal|cancel)$|_simulation\/command$/;

/** Topics that a person can control. */
export function controllableTopics(graph: Graph): string[] {
  const { topics, publishers, subscribers, ownNodes } = graph;
  const isFree = (topic: string) => publishers.get(topic)?.every((node) => ownNodes.includes(node)) ?? true;
  return [...subscribers.keys()]
    .filter(
      (each) => !NOT_FOR_HANDS.test(each) && topics.has(each) && hasSubscriber(graph, each) && isFree(each),
    )
    .sort();
}

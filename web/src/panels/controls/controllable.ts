// Which topics wait for input: a node subscribes, and no other node publishes.
import type { Graph } from "../panel.ts";

// Subscribed by tools and by every node, never meant for a person's finger.
const NOT_FOR_HANDS =
  /^\/(rosout|rosout_agg|clock|tf|tf_static|diagnostics|parameter_events)$|\/(feedback|status|result|goal|cancel)$|_simulation\/command$/;

/**
 * Topics a person can control.
 *
 * @param ownNode the gateway's node, which publishes and subscribes for pages.
 */
export function controllableTopics(graph: Graph, ownNode: string | undefined): string[] {
  const names: string[] = [];
  for (const [topic, subscribers] of graph.subscribers) {
    if (NOT_FOR_HANDS.test(topic) || !graph.topics.has(topic)) continue;
    const others = (nodes: readonly string[] | undefined) => (nodes ?? []).filter((node) => node !== ownNode);
    if (others(subscribers).length > 0 && others(graph.publishers.get(topic)).length === 0) names.push(topic);
  }
  return names.sort();
}

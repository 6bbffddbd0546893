import type { Panel } from "../panel.ts";
import { controllableTopics } from "./controllable.ts";

export const controlsPanel: Panel = {
  id: "controls",
  title: "controls",
  icon: "controls",
  onTabBar: true,
  matches: (graph) =>
    controllableTopics(graph, graph.ownNode).map((topic) => ({
      key: topic,
      title: topic,
      settings: { topic },
      order: 10,
    })),
  load: () => import("./controls_panel.tsx"),
};

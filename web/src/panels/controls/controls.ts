import type { Panel } from "../panel.ts";
import { hasFields, isByTopic, isNumber, isText } from "../setting_checks.ts";
import { fitsCard } from "./control_kind.ts";
import { controllableTopics } from "./controllable.ts";

export const controlsPanel: Panel = {
  id: "controls",
  title: "controls",
  icon: "controls",
  onTabBar: true,
  matches: (graph) =>
    controllableTopics(graph)
      .filter((name) => {
        const topic = graph.topics.get(name);
        return topic !== undefined && fitsCard(topic);
      })
      .map((topic) => ({ key: topic, title: topic, settings: { topic }, order: 10 })),
  settings: { topic: isText, ranges: isByTopic(hasFields({ min: isNumber, max: isNumber })) },
  shared: ["ranges"],
  load: () => import("./controls_panel.tsx"),
};

import type { Panel } from "../panel.ts";
import { plotSuggestions } from "./suggestions.ts";

export const plotsPanel: Panel = {
  id: "plots",
  title: "plots",
  icon: "plots",
  onTabBar: true,
  fillsPage: true,
  matches: plotSuggestions,
  load: () => import("./plots_panel.tsx"),
};

import type { Panel } from "../panel.ts";
import { isNumber, isText, isTexts } from "../setting_checks.ts";
import { plotSuggestions } from "./suggestions.ts";

export const plotsPanel: Panel = {
  id: "plots",
  title: "plots",
  icon: "plots",
  onTabBar: true,
  fillsPage: true,
  matches: plotSuggestions,
  settings: {
    series: isTexts,
    names: isTexts,
    span: isNumber,
    ownAxes: isTexts,
    add: isText,
  },
  load: () => import("./plots_panel.tsx"),
};

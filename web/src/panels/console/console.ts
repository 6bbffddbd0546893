import type { Panel } from "../panel.ts";
import { isOneOf, isText } from "../setting_checks.ts";
import { LEVELS } from "./log_lines.ts";

export const consolePanel: Panel = {
  id: "console",
  title: "console",
  icon: "console",
  fillsPage: true,
  settings: { level: isOneOf(LEVELS), node: isText, search: isText },
  load: () => import("./console_panel.tsx"),
};

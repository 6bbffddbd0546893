import type { Panel } from "../panel.ts";

export const consolePanel: Panel = {
  id: "console",
  title: "console",
  icon: "console",
  fillsPage: true,
  load: () => import("./console_panel.tsx"),
};

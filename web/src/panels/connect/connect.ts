import type { Panel } from "../panel.ts";

export const connectPanel: Panel = {
  id: "connect",
  title: "connect",
  icon: "plug",
  load: () => import("./connect_panel.tsx"),
};

import type { Panel } from "../panel.ts";

export const phonePanel: Panel = {
  id: "phone",
  title: "phone",
  icon: "phone",
  load: () => import("./phone_panel.tsx"),
};

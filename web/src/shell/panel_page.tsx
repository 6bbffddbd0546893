// One panel as a whole page. Its settings are those of the link, or else the saved ones.
import { effect, signal, untracked } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { mountPanel } from "../panels/host.ts";
import type { Panel } from "../panels/panel.ts";
import { validSettings } from "../panels/setting_checks.ts";
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { route } from "./route.ts";
import { saveChanges, savedSettings } from "./saved_settings.ts";

export function PanelPage({ panel, robot }: { panel: Panel; robot: Robot }) {
  const host = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const given = () =>
      route.value.panelId === panel.id ? validSettings(route.value.settings, panel.settings) : {};
    const settings = signal({ ...savedSettings(panel), ...untracked(given) });
    const dispose = mountPanel(panel, host.current!, robot, settings, false);
    const stopSaving = saveChanges(panel, settings, () => untracked(given));
    // A link to the same panel has other settings.
    const stopFollowing = effect(() => {
      const now = given();
      if (Object.keys(now).length > 0) settings.value = { ...settings.peek(), ...now };
    });
    return () => {
      stopFollowing();
      stopSaving();
      dispose();
    };
  }, [panel, robot]);
  return (
    <>
      <h1 class="for-readers">{texts.panels[panel.title]}</h1>
      <div class={`page page-${panel.id}`} ref={host} />
    </>
  );
}

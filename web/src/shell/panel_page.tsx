// One panel as a whole page. Its settings are those of the link, or else the saved ones.
import { effect, type Signal, signal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { mountPanel } from "../panels/host.ts";
import type { Panel, Settings } from "../panels/panel.ts";
import type { Robot } from "../store/robot.ts";
import { loadSetting, saveSetting } from "../store/storage.ts";
import { texts } from "../texts.ts";
import { route } from "./route.ts";

export function PanelPage({ panel, robot }: { panel: Panel; robot: Robot }) {
  const host = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const settings = pageSettings(panel.id);
    const dispose = mountPanel(panel, host.current!, robot, settings, false);
    const key = `panel.${panel.id}`;
    const first = settings.value;
    const stopSaving = effect(() => {
      if (settings.value !== first) saveSetting(key, settings.value);
    });
    // A link to the same panel has other settings.
    const stopFollowing = effect(() => {
      const given = route.value.panelId === panel.id ? route.value.settings : undefined;
      if (given) settings.value = { ...settings.peek(), ...given };
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

function pageSettings(panelId: string): Signal<Settings> {
  return signal({ ...loadSetting<Settings>(`panel.${panelId}`, {}), ...route.peek().settings });
}

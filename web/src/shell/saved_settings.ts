// The settings of panels that are kept when the page is closed: the user's changes, not the values of links and cards.
import { effect, type Signal } from "@preact/signals";
import type { Panel } from "../panels/panel.ts";
import { type Settings, validSettings } from "../panels/setting_checks.ts";
import { loadSetting, saveSetting } from "../store/storage.ts";

export function savedSettings({ id, settings }: Panel): Settings {
  return validSettings(loadSetting<Settings | null>(keyOf(id), null), settings);
}

/** The settings that the panel's cards share with its page. */
export function sharedSettings(panel: Panel): Settings {
  const saved = savedSettings(panel);
  return Object.fromEntries(
    (panel.shared ?? []).flatMap((name) => (name in saved ? [[name, saved[name]]] : [])),
  );
}

/** Saves changes until the returned function is called. `given` returns the values from the link or the card. */
export function saveChanges(panel: Panel, settings: Signal<Settings>, given: () => Settings): () => void {
  let before = settings.peek();
  return effect(() => {
    const now = settings.value;
    const changed = Object.entries(now).filter(
      ([name, each]) => each !== before[name] && each !== given()[name],
    );
    before = now;
    if (changed.length === 0) return;
    const saved = savedSettings(panel);
    for (const [name, each] of changed) {
      // A card has old values of other topics: those from when it was built.
      saved[name] = panel.shared?.includes(name) ? { ...(saved[name] as object), ...(each as object) } : each;
    }
    saveSetting(keyOf(panel.id), saved);
  });
}

function keyOf(panelId: string): string {
  return `panel.${panelId}`;
}

// Dark or light colors: the setting of the system, until the user chooses.
import { effect, signal } from "@preact/signals";
import { loadSetting, saveSetting } from "../store/storage.ts";

export type Theme = "dark" | "light";

const system = matchMedia("(prefers-color-scheme: dark)");
const chosen = signal<Theme | null>(loadSetting<Theme | null>("theme", null));
const systemTheme = signal<Theme>(system.matches ? "dark" : "light");
system.addEventListener("change", () => {
  systemTheme.value = system.matches ? "dark" : "light";
});

export const theme = signal<Theme>("light");
effect(() => {
  theme.value = chosen.value ?? systemTheme.value;
  document.documentElement.dataset.theme = theme.value;
});

export function toggleTheme(): void {
  chosen.value = theme.value === "dark" ? "light" : "dark";
  saveSetting("theme", chosen.value);
}

/** The color of a style variable now, such as `--accent`, for canvases. */
export function color(variable: string): string {
  void theme.value;
  return getComputedStyle(document.documentElement).getPropertyValue(variable).trim();
}

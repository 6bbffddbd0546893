// The address of the current view: `#/PANEL`, with the panel's settings in a shared link: `#/PANEL?s=...`.
import { signal } from "@preact/signals";
import type { Settings } from "../panels/setting_checks.ts";

export interface Route {
  /** Empty for the overview. */
  panelId: string;
  /** The settings in the link; undefined if it has none. */
  settings: Settings | undefined;
}

const MAX_LINK_CHARACTERS = 20_000;

export const route = signal<Route>(parse(location.hash));
addEventListener("hashchange", () => {
  route.value = parse(location.hash);
});

/** Opens a panel's page; an empty id is the overview. */
export function navigate(panelId: string, settings?: Settings): void {
  location.hash = linkTo(panelId, settings);
}

/** The fragment of a panel's page, with settings in it when they are given. */
export function linkTo(panelId: string, settings?: Settings): string {
  return `#/${panelId}${settings ? `?s=${encodeSettings(settings)}` : ""}`;
}

function parse(hash: string): Route {
  const [path = "", query = ""] = hash.replace(/^#\/?/, "").split("?", 2);
  const panelId = /^[a-z0-9]+$/.test(path) ? path : "";
  const encoded = new URLSearchParams(query).get("s");
  return { panelId, settings: encoded ? decodeSettings(encoded) : undefined };
}

function encodeSettings(settings: Settings): string {
  const bytes = new TextEncoder().encode(JSON.stringify(settings));
  let binary = "";
  for (const each of bytes) binary += String.fromCharCode(each);
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** Settings of a link, undefined when they are damaged. */
function decodeSettings(encoded: string): Settings | undefined {
  if (encoded.length > MAX_LINK_CHARACTERS) return undefined;
  try {
    const binary = atob(encoded.replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(binary, (each) => each.charCodeAt(0));
    const value: unknown = JSON.parse(new TextDecoder().decode(bytes));
    return typeof value === "object" && value !== null && !Array.isArray(value)
      ? (value as Settings)
      : undefined;
  } catch {
    return undefined;
  }
}

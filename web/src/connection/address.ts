// The address of the gateway, and its token. The token is in the fragment of the page's URL, which browsers do not send.

const TOKEN_KEY = "rostether.token";

/** Moves a token from the address bar (`#token=7f3c9a`) into this tab's storage. */
export function keepToken(): void {
  const match = /(?:^#|[#&?])token=([^&]+)/.exec(location.hash);
  if (!match) return;
  sessionStorage.setItem(TOKEN_KEY, decodeURIComponent(match[1]!));
  const rest = location.hash.replace(/([#&?])token=[^&]*&?/, "$1").replace(/[#&?]+$/, "");
  history.replaceState(null, "", location.pathname + location.search + rest);
}

/** The addresses of map tiles, from the gateway's pattern with {z}, {x} and {y}. */
export function tilesUrl(pattern: string): string {
  const token = sessionStorage.getItem(TOKEN_KEY);
  return `${pattern}${token ? `?token=${encodeURIComponent(token)}` : ""}`;
}

/** The address of a finished recording; the token is in the address, because a download cannot send it in a header. */
export function recordingUrl(name: string): string {
  const token = sessionStorage.getItem(TOKEN_KEY);
  return `/recordings/${encodeURIComponent(name)}${token ? `?token=${encodeURIComponent(token)}` : ""}`;
}

/** The address at which the robot accepts boards on this device's serial ports. */
export function serialUrl(): string {
  const url = new URL(gatewayUrl());
  url.pathname = "/serial";
  return url.href;
}

/** The gateway's address; `?ws=ws://HOST:PORT` in the page's address overrides the server of the page. */
export function gatewayUrl(): string {
  const given = new URLSearchParams(location.search).get("ws");
  const url = new URL(given ?? location.href);
  if (!given) {
    url.search = "";
    url.pathname = "/";
  }
  url.protocol = url.protocol === "https:" || url.protocol === "wss:" ? "wss:" : "ws:";
  url.hash = "";
  const token = sessionStorage.getItem(TOKEN_KEY);
  // A token is only for the server of the page, never for a server in a link.
  if (token && (!given || url.hostname === location.hostname)) url.searchParams.set("token", token);
  return url.href;
}

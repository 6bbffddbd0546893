// Settings that are kept when the page is closed. Private windows and full disks refuse storage; the page also works
// without storage.

const PREFIX = "rostether.";

export function loadSetting<T>(key: string, otherwise: T): T {
  try {
    const text = localStorage.getItem(PREFIX + key);
    return text === null ? otherwise : (JSON.parse(text) as T);
  } catch {
    return otherwise;
  }
}

export function saveSetting(key: string, value: unknown): void {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(value));
  } catch {
    // Without storage, the setting is kept while the page is open.
  }
}

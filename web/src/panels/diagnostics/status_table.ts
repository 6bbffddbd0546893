// The latest status of each component, from /diagnostics.

export interface DiagnosticStatus {
  level: number;
  name: string;
  message: string;
  hardware_id: string;
  values: { key: string; value: string }[];
}
export interface Entry {
  readonly status: DiagnosticStatus;
  readonly receivedMs: number;
}

// More components than any robot has.
const MAX_ENTRIES = 2000;
// diagnostic_aggregator regards a status as stale after this time.
const STALE_MS = 5000;

export class StatusTable {
  readonly entries = new Map<string, Entry>();

  /** Adds a diagnostic_msgs/DiagnosticArray. */
  add(message: unknown, receivedMs: number): void {
    for (const status of (message as { status: DiagnosticStatus[] }).status) {
      if (this.entries.size >= MAX_ENTRIES && !this.entries.has(status.name)) continue;
      this.entries.set(status.name, { status, receivedMs });
    }
  }

  /** Returns the components, the worst first, then by name. */
  sorted(nowMs: number): (Entry & { level: "ok" | "warning" | "error" | "stale" })[] {
    return [...this.entries.values()]
      .map((entry) => ({ ...entry, level: levelOf(entry, nowMs) }))
      .sort((a, b) => rank(b.level) - rank(a.level) || (a.status.name < b.status.name ? -1 : 1));
  }
}

function levelOf({ status, receivedMs }: Entry, nowMs: number): "ok" | "warning" | "error" | "stale" {
  if (nowMs - receivedMs > STALE_MS || status.level === 3) return "stale";
  return status.level === 0 ? "ok" : status.level === 1 ? "warning" : "error";
}

function rank(level: string): number {
  return { error: 3, warning: 2, stale: 1, ok: 0 }[level] ?? 0;
}

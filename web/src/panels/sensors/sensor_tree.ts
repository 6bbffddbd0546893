// Groups the listed sensors by robot and type.
import { compareNames } from "../../shell/format.ts";
import type { Level } from "../../shell/parts.tsx";

export const SENSORS_TYPE = "sensing_platform/Sensors";

/** sensing_platform/Sensor. */
export interface Sensor {
  id: string;
  name: string;
  platform_name: string;
  sensor_type: string;
  topic: string;
  message_type: string;
  unit: string;
  rate_hz: number;
  state: string;
  state_text: string;
}

export interface Platform {
  name: string;
  /** The worst state of its sensors. */
  level: Level;
  types: { name: string; sensors: Sensor[] }[];
}

const LEVELS: Record<string, Level> = {
  init: "warning",
  ready: "ok",
  sleeping: "stale",
  lost: "error",
  disconnected: "error",
  alert: "warning",
};
const WORST: readonly Level[] = ["error", "warning", "ok", "stale"];

export function levelOf(sensor: Sensor): Level {
  return LEVELS[sensor.state] ?? "stale";
}

/** The platforms whose sensors have all words of `search` in their names, types, states or topics. */
export function sensorTree(sensors: readonly Sensor[], search: string): Platform[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const platforms = new Map<string, Map<string, Sensor[]>>();
  for (const each of sensors) {
    const text =
      `${each.platform_name} ${each.sensor_type} ${each.name} ${each.state} ${each.topic}`.toLowerCase();
    if (!words.every((word) => text.includes(word))) continue;
    const types = platforms.get(each.platform_name) ?? new Map<string, Sensor[]>();
    platforms.set(each.platform_name, types);
    types.set(each.sensor_type, [...(types.get(each.sensor_type) ?? []), each]);
  }
  return sorted(platforms).map(([name, types]) => ({
    name,
    level: WORST.find((level) => [...types.values()].flat().some((each) => levelOf(each) === level))!,
    types: sorted(types).map(([type, found]) => ({
      name: type,
      sensors: found.sort((a, b) => compareNames(a.name, b.name) || compareNames(a.topic, b.topic)),
    })),
  }));
}

function sorted<Item>(table: Map<string, Item>): [string, Item][] {
  return [...table].sort(([a], [b]) => compareNames(a, b));
}

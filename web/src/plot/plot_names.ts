// Values as rqt_plot names them: `/imu/angular_velocity/x`, `/odom/pose/pose/position/x:y`, `/ultrasound`.
import type { Topic } from "../store/topics.ts";
import { numericPaths, pathReader } from "../wire/path.ts";

const MAX_FIELDS = 8;

/**
 * The series of a name; undefined while no topic of the graph fits.
 *
 * @param name topic and fields with slashes; `:` separates several last fields. A topic alone means its numbers.
 */
export function seriesOfName(name: string, topics: ReadonlyMap<string, Topic>): string[] | undefined {
  const full = name.startsWith("/") ? name : `/${name}`;
  for (let end = full.length; end > 0; end = full.lastIndexOf("/", end - 1)) {
    const topic = topics.get(full.slice(0, end));
    if (!topic) continue;
    const [path = "", ...others] = full
      .slice(end + 1)
      .replaceAll("/", ".")
      .split(":");
    if (path === "") return numbersOf(topic).map((each) => `${topic.name}.${each}`);
    const start = path.slice(0, path.lastIndexOf(".") + 1);
    return [path, ...others.map((each) => start + each)].map((each) => `${topic.name}.${each}`);
  }
  return undefined;
}

/** The series of a typed name, also with dots, such as `/scan.ranges[3]`; empty unless its topic has these numbers. */
export function seriesOfTyped(text: string, topics: ReadonlyMap<string, Topic>): string[] {
  const series = seriesOfName(text.trim().replaceAll(".", "/"), topics) ?? [];
  return series.every((each) => isNumber(each, topics)) ? series : [];
}

function isNumber(series: string, topics: ReadonlyMap<string, Topic>): boolean {
  const end = series.indexOf(".");
  try {
    pathReader(topics.get(series.slice(0, end))!.type(), series.slice(end + 1));
    return true;
  } catch {
    return false;
  }
}

function numbersOf(topic: Topic): string[] {
  try {
    const paths = numericPaths(topic.type(), 50).filter((path) => !path.endsWith("[:]"));
    const own = paths.filter((path) => !path.startsWith("header."));
    return own.slice(0, MAX_FIELDS);
  } catch {
    return [];
  }
}

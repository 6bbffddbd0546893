// Series that receive: while their chart is visible, or, for chosen plots, while the page is.
import { computed, effect, type ReadonlySignal } from "@preact/signals";
import type { Robot, Subscription } from "../store/robot.ts";
import { pageHidden } from "../store/visibility.ts";
import type { Series } from "./series.ts";

const pageVisible = computed(() => !pageHidden.value);
const kept = new WeakMap<Robot, Map<Series, () => void>>();

/** Receives a series while `visible` is true; returns a function that stops it. */
export function receiveSeries(robot: Robot, series: Series, visible: ReadonlySignal<boolean>): () => void {
  const feed = robot.feed(series.topicName);
  const stopFollowing = effect(() => series.follow(feed.topic.value));
  let subscription: Subscription | undefined;
  const pause = () => {
    if (subscription === undefined) return;
    subscription.close();
    subscription = undefined;
    series.receivers--;
    if (series.receivers === 0) series.buffer.interrupt();
  };
  const stopWatching = effect(() => {
    if (!visible.value) pause();
    else if (subscription === undefined) {
      series.receivers++;
      subscription = robot.subscribe(series.topicName, (arrival) => series.receive(arrival));
    }
    if (robot.connection.value !== "open") series.buffer.interrupt();
  });
  return () => {
    stopWatching();
    stopFollowing();
    pause();
  };
}

/**
 * Receives these series, instead of those of the last call, while the page is visible. So a plot has no gap when the user
 * returns from another panel.
 */
export function keepSeries(robot: Robot, wanted: readonly Series[]): void {
  const running = kept.get(robot) ?? new Map<Series, () => void>();
  kept.set(robot, running);
  for (const [each, end] of running) {
    if (wanted.includes(each)) continue;
    end();
    running.delete(each);
  }
  for (const each of wanted) {
    if (!running.has(each)) running.set(each, receiveSeries(robot, each, pageVisible));
  }
}

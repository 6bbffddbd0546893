// Series by their names, receiving while the panel is visible.
import { effect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { type Series, seriesStore } from "../../plot/series.ts";
import type { PanelContext } from "../panel.ts";

export function useSeries(context: PanelContext, ids: readonly string[]): Series[] {
  const key = ids.join("\n");
  const series = useMemo(() => ids.map((id) => seriesStore(context.robot).get(id)), [key]);
  // Their units and axes depend on types, which are known after the connection.
  for (const each of series) each.follow(context.robot.topics.value.get(each.topicName));
  useEffect(() => {
    const endings = series.map((each) => {
      const feed = context.robot.feed(each.topicName);
      const stopFollowing = effect(() => each.follow(feed.topic.value));
      const subscription = context.subscribe(each.topicName, (arrival) => each.receive(arrival));
      return () => {
        stopFollowing();
        subscription.close();
        each.buffer.interrupt();
      };
    });
    const stopWatching = effect(() => {
      if (context.visible.value && context.robot.connection.value === "open") return;
      for (const each of series) each.buffer.interrupt();
    });
    return () => {
      stopWatching();
      for (const end of endings) end();
    };
  }, [series]);
  return series;
}

/** The axis that a series is on unless it has its own: one for each unit. */
export function axisKey(series: Series): string {
  return series.isStepped ? "flag" : series.unit || "value";
}

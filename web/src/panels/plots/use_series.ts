// Series by their names, receiving while the panel is visible.
import { useLayoutEffect, useMemo } from "preact/hooks";
import { keepSeries, receiveSeries } from "../../plot/receiving.ts";
import { type Series, seriesStore } from "../../plot/series.ts";
import type { PanelContext } from "../panel.ts";

/** The series with these ids. With `isKept`, series over time also receive while another panel is shown. */
export function useSeries(context: PanelContext, ids: readonly string[], isKept = false): Series[] {
  const key = ids.join("\n");
  const { robot } = context;
  const series = useMemo(() => ids.map((id) => seriesStore(robot).get(id)), [key]);
  // Units and axes of series depend on types, which are known after the connection.
  for (const each of series) each.follow(robot.topics.value.get(each.topicName));
  useLayoutEffect(() => {
    if (isKept)
      keepSeries(
        robot,
        series.filter((each) => !each.isArray),
      );
    const others = series.filter((each) => !isKept || each.isArray);
    const endings = others.map((each) => receiveSeries(robot, each, context.visible));
    return () => {
      for (const end of endings) end();
    };
  }, [series]);
  return series;
}

/** The axis that a series is on unless it has its own: one for each unit. */
export function axisKey(series: Series): string {
  return series.isStepped ? "flag" : series.unit || "value";
}

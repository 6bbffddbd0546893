// The positions of robots with GPS (sensor_msgs/NavSatFix), on offline tiles or a grid.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { tilesUrl } from "../../connection/address.ts";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { FIX_TYPE } from "./map.ts";
import { MapView } from "./map_view.ts";

/** sensor_msgs/NavSatStatus: STATUS_NO_FIX. */
const NO_FIX = -1;

interface Fix {
  status: { status: number };
  latitude: number;
  longitude: number;
}

function MapPanel({ context }: { context: PanelContext }) {
  const host = useRef<HTMLDivElement>(null);
  const view = useSignal<MapView | undefined>(undefined);
  const isFollowing = useSignal(true);
  const waiting = useSignal<string[]>([]);
  const metadata = context.robot.info.value?.metadata;
  const pattern = metadata?.tiles;
  const maxZoom = Number(metadata?.tiles_max_zoom ?? 19);
  useEffect(() => {
    const made = new MapView(
      host.current as HTMLDivElement,
      pattern === undefined ? undefined : { url: tilesUrl(pattern), maxZoom },
      () => {
        isFollowing.value = false;
      },
    );
    view.value = made;
    const followed = new Map<string, () => void>();
    const withoutFix = new Set<string>();
    const end = effect(() => {
      for (const topic of context.robot.topics.value.values()) {
        if (topic.typeName !== FIX_TYPE || topic.channelId === undefined || followed.has(topic.name))
          continue;
        const { feed, close } = context.subscribe(topic.name, () => {
          const fix = feed.lastValid() as unknown as Fix | undefined;
          if (!fix) return;
          const isOnEarth = Math.abs(fix.latitude) <= 90 && Math.abs(fix.longitude) <= 180;
          const found = fix.status.status !== NO_FIX && isOnEarth;
          if (found === withoutFix.has(topic.name)) {
            if (found) withoutFix.delete(topic.name);
            else withoutFix.add(topic.name);
            waiting.value = [...withoutFix];
          }
          if (found) made.move(topic.name, fix);
        });
        followed.set(topic.name, close);
      }
    });
    return () => {
      end();
      for (const close of followed.values()) close();
      made.dispose();
    };
  }, [pattern]);
  const hasTopic = [...context.robot.topics.value.values()].some((each) => each.typeName === FIX_TYPE);
  return (
    <div class="map">
      <div class="map-picture" ref={host} />
      {!hasTopic && <EmptyState icon="map" title={texts.map.none} text={texts.map.noneText} />}
      <div class="map-tools">
        <button type="button" class="button" onClick={() => view.value?.fit()}>
          {texts.map.fit}
        </button>
        <button
          type="button"
          class="button"
          aria-pressed={isFollowing.value}
          onClick={() => {
            isFollowing.value = !isFollowing.value;
            if (view.value) view.value.isFollowing = isFollowing.value;
          }}
        >
          {texts.map.follow}
        </button>
      </div>
      <div class="map-notes">
        {waiting.value.length > 0 && <p class="warning">{texts.map.noFix(waiting.value.join(", "))}</p>}
        {pattern === undefined && !context.isCard && <p>{texts.map.noTiles}</p>}
      </div>
    </div>
  );
}

export default preactPanel(MapPanel);

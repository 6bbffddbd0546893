// All sensors of all robots as a tree, and the values of those that are chosen.
import { type Signal, useComputed } from "@preact/signals";
import { Icon } from "../../shell/icons.tsx";
import { EmptyState, IconButton, SearchField } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useFeed } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { SensorPane } from "./sensor_pane.tsx";
import { levelOf, type Platform, SENSORS_TYPE, type Sensor, sensorTree } from "./sensor_tree.ts";

interface SensorsSettings {
  /** Ids of the sensors that are shown. */
  chosen?: string[];
  search?: string;
  /** Platforms whose branch is folded. */
  folded?: string[];
}

// Each chosen sensor is a subscription.
const MAX_CHOSEN = 12;
// Larger fleets begin folded, so that the robots fit a phone.
const MAX_UNFOLDED = 4;

const t = texts.sensors;

function SensorsPanel({ context }: { context: PanelContext }) {
  const { robot } = context;
  const settings = context.settings as Signal<SensorsSettings>;
  const topic = useComputed(
    () => [...robot.topics.value.values()].find((each) => each.typeName === SENSORS_TYPE)?.name ?? "/sensors",
  ).value;
  const feed = useFeed(context, topic);
  const sensors = (feed.lastValid()?.sensors ?? []) as unknown as Sensor[];
  const { search = "", chosen = [] } = settings.value;
  const change = (to: SensorsSettings) => {
    settings.value = { ...settings.value, ...to };
  };
  if (sensors.length === 0)
    return <EmptyState icon="sensors" title={t.none} text={t.noneText} command={t.noneCommand} />;
  const tree = sensorTree(sensors, search);
  const folded = new Set(settings.value.folded ?? (tree.length > MAX_UNFOLDED ? names(tree) : []));
  const toggle = (id: string) =>
    change({
      chosen: chosen.includes(id) ? chosen.filter((each) => each !== id) : [...chosen, id].slice(-MAX_CHOSEN),
    });
  const shown = chosen.flatMap((id) => sensors.find((each) => each.id === id) ?? []);
  return (
    <div class="sensors">
      <div class="sensors-list">
        <SearchField value={search} label={t.search} onInput={(text) => change({ search: text })} />
        {tree.length === 0 && <p class="empty-line">{t.noMatch}</p>}
        {tree.map((platform) => (
          <Branch
            key={platform.name}
            platform={platform}
            chosen={chosen}
            isOpen={search !== "" || !folded.has(platform.name)}
            onToggle={(isOpen) => {
              if (search !== "") return;
              if (isOpen) folded.delete(platform.name);
              else folded.add(platform.name);
              change({ folded: [...folded] });
            }}
            onChoose={toggle}
          />
        ))}
      </div>
      <div class="sensors-panes">
        {shown.length === 0 && <p class="empty-line">{t.choose}</p>}
        {shown.map((each) => (
          <section key={each.id} class="sensor-pane" aria-label={each.name}>
            <header>
              <h2>{each.name}</h2>
              <span class="sensor-platform">{each.platform_name}</span>
              <IconButton icon="close" label={t.close} onClick={() => toggle(each.id)} />
            </header>
            <SensorPane context={context} sensor={each} />
          </section>
        ))}
      </div>
    </div>
  );
}

function Branch(props: {
  platform: Platform;
  chosen: readonly string[];
  isOpen: boolean;
  onToggle: (isOpen: boolean) => void;
  onChoose: (id: string) => void;
}) {
  const { platform, chosen, isOpen, onToggle, onChoose } = props;
  const count = platform.types.reduce((sum, each) => sum + each.sensors.length, 0);
  return (
    <details
      class="sensors-platform"
      open={isOpen}
      onToggle={(event) => {
        // The event also occurs when the attribute `open` is set.
        if (event.currentTarget.open !== isOpen) onToggle(event.currentTarget.open);
      }}
    >
      <summary>
        <Icon name="chevron" size={16} />
        <span class={`badge ${platform.level}`}>{platform.name}</span>
        <span class="sensors-count">{count}</span>
      </summary>
      {isOpen &&
        platform.types.map((type) => (
          <ul key={type.name} aria-label={type.name}>
            <li class="sensors-type">{type.name}</li>
            {type.sensors.map((each) => (
              <li key={each.id}>
                <button
                  type="button"
                  class="sensor"
                  aria-pressed={chosen.includes(each.id)}
                  title={each.topic}
                  onClick={() => onChoose(each.id)}
                >
                  <span class="sensor-name">{each.name}</span>
                  <span class={`badge ${levelOf(each)}`}>
                    {t.states[each.state as keyof typeof t.states] ?? each.state}
                  </span>
                </button>
              </li>
            ))}
          </ul>
        ))}
    </details>
  );
}

function names(tree: readonly Platform[]): string[] {
  return tree.map((each) => each.name);
}

export default preactPanel(SensorsPanel);

// The robots of a fleet: a card for each with its state, its connection to the base, and a stop button.
import { useComputed, useSignal } from "@preact/signals";
import { compareNames, formatDuration } from "../../shell/format.ts";
import { Icon } from "../../shell/icons.tsx";
import { Badge, EmptyState, type Level } from "../../shell/parts.tsx";
import { callService } from "../../store/call_service.ts";
import { texts } from "../../texts.ts";
import { useFeed } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { FLEET_TYPE, type RobotState, STOP_TYPE } from "./fleet_messages.ts";

// Above this, a robot gets its commands by unicast too.
const HIGH_LOSS = 0.1;
// Below this, Wi-Fi begins to fail.
const WEAK_DBM = -75;

const t = texts.fleet;

function FleetPanel({ context }: { context: PanelContext }) {
  const { robot } = context;
  const topic = useComputed(
    () => [...robot.topics.value.values()].find((each) => each.typeName === FLEET_TYPE)?.name ?? "/fleet",
  ).value;
  const feed = useFeed(context, topic);
  const answer = useSignal("");
  const robots = (feed.lastValid()?.robots ?? []) as unknown as RobotState[];
  const service = [...robot.services.value.values()].find((each) => each.type === STOP_TYPE);
  const stop = async (id: number) => {
    answer.value = t.stopping;
    try {
      const { confirmed } = await callService(robot, service!, { robot: id });
      answer.value = t.confirmed((confirmed as ArrayLike<number>).length);
    } catch (error) {
      answer.value = (error as Error).message;
    }
  };
  const stopOf = service && robot.mayAct.value ? (id: number) => void stop(id) : undefined;
  if (robots.length === 0) {
    return feed.topic.value ? (
      <EmptyState icon="fleet" title={t.noAnswer} text={t.noAnswerText} command={t.noAnswerCommand} />
    ) : (
      <EmptyState icon="fleet" title={t.none} text={t.noneText} command={t.noneCommand} />
    );
  }
  const nowS = Number(feed.last!.timeNs) / 1e9;
  const lost = robots.filter((each) => each.state === "lost").length;
  return (
    <div class="fleet">
      <div class="toolbar">
        <span class="fleet-count">{t.count(robots.length - lost, lost)}</span>
        <output class="fleet-answer">{answer.value}</output>
        {stopOf && (
          <button type="button" class="fleet-stop" onClick={() => stopOf(0)}>
            <Icon name="stop" />
            {t.stopAll}
          </button>
        )}
      </div>
      <ul class={context.isCard ? "fleet-badges" : "fleet-robots"}>
        {[...robots]
          .sort((a, b) => a.id - b.id || compareNames(a.address, b.address))
          .map((each) =>
            context.isCard ? (
              <li key={`${each.id} ${each.address}`}>
                <Badge level={levelOf(each)}>{t.robot(each.id)}</Badge>
              </li>
            ) : (
              <RobotCard key={`${each.id} ${each.address}`} state={each} nowS={nowS} stop={stopOf} />
            ),
          )}
      </ul>
    </div>
  );
}

function RobotCard(props: { state: RobotState; nowS: number; stop: ((id: number) => void) | undefined }) {
  const { state, nowS, stop } = props;
  const isLost = state.state === "lost";
  const ageS = Math.max(0, nowS - state.answered.sec - state.answered.nsec / 1e9);
  return (
    <li class={isLost ? "robot is-lost" : "robot"} aria-label={t.robot(state.id)}>
      <header>
        <h2>{t.robot(state.id)}</h2>
        <Badge level={levelOf(state)}>
          {isLost ? t.lostFor(formatDuration(ageS)) : (t.states[state.state as "moving"] ?? state.state)}
        </Badge>
      </header>
      <dl>
        <Fact name={t.address} text={state.address} />
        <Fact name={t.commandedBy} text={state.commanded_by || t.notCommanded} />
        <Fact
          name={t.loss}
          text={Number.isFinite(state.loss) ? `${(state.loss * 100).toFixed(0)} %` : "–"}
          isBad={state.loss > HIGH_LOSS}
          note={state.uses_unicast ? t.unicast : ""}
        />
        <Fact
          name={t.signal}
          text={state.signal_dbm ? `${state.signal_dbm} dBm` : "–"}
          isBad={state.signal_dbm !== 0 && state.signal_dbm < WEAK_DBM}
        />
      </dl>
      {stop && (
        <button type="button" class="button" onClick={() => stop(state.id)}>
          {t.stop}
        </button>
      )}
    </li>
  );
}

function Fact(props: { name: string; text: string; isBad?: boolean; note?: string }) {
  return (
    <div>
      <dt>{props.name}</dt>
      <dd class={props.isBad ? "bad" : undefined}>
        {props.text}
        {props.note && <span class="robot-note"> {props.note}</span>}
      </dd>
    </div>
  );
}

function levelOf({ state, loss }: RobotState): Level {
  if (state === "lost") return "error";
  return loss > HIGH_LOSS ? "warning" : "ok";
}

export default preactPanel(FleetPanel);

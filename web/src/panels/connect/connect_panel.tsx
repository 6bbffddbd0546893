// Boards on the serial ports of the device that shows this page.
import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { BoardRelay } from "../../serial/board_relay.ts";
import {
  BAUDS,
  type BoardSettings,
  boardSettings,
  connectBoard,
  disconnectBoard,
  relays,
} from "../../serial/boards_here.ts";
import { type SerialPort, serialPorts } from "../../serial/web_serial.ts";
import { formatBytes } from "../../shell/format.ts";
import { Badge, EmptyState, type Level } from "../../shell/parts.tsx";
import { isDeviceName } from "../../store/device_name.ts";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";

const t = texts.connect;
const LEVELS: Record<BoardRelay["state"]["value"], Level> = {
  opening: "stale",
  connected: "ok",
  away: "warning",
  hidden: "stale",
  unplugged: "error",
};

function ConnectPanel({ context }: { context: PanelContext }) {
  const { info } = context.robot;
  const chosen = useSignal<SerialPort | undefined>(undefined);
  const problem = useSignal("");
  const known = useKnownPorts();
  if (!info.value) return null;
  const { rights, features = "" } = info.value.metadata ?? {};
  if (rights === "view") return <EmptyState icon="plug" title={t.viewOnly} text={t.viewOnlyText} />;
  if (!features.split(",").includes("serial")) {
    return (
      <EmptyState icon="plug" title={t.notOffered} text={t.notOfferedText} command={t.notOfferedCommand} />
    );
  }
  if (!isSecureContext) return <EmptyState icon="plug" title={t.insecure} text={t.insecureText} />;
  const serial = serialPorts();
  if (!serial) return <EmptyState icon="plug" title={t.unsupported} text={t.unsupportedText} />;

  const choose = async () => {
    problem.value = "";
    try {
      chosen.value = await serial.requestPort();
    } catch (error) {
      // NotFoundError: the user closed the list of ports.
      if (!(error instanceof DOMException && error.name === "NotFoundError")) problem.value = String(error);
    }
  };
  const used = relays.value.map((each) => each.port);
  const others = known.value.filter((each) => !used.includes(each) && each !== chosen.value);
  return (
    <div class="connect">
      <p>{t.intro}</p>
      {relays.value.map((relay) => (
        <RelayCard key={relay} context={context} relay={relay} />
      ))}
      {chosen.value && <PortForm key={chosen.value} port={chosen as Signal<SerialPort>} problem={problem} />}
      {problem.value && (
        <p class="problem" role="alert">
          {problem.value}
        </p>
      )}
      <div class="connect-ports">
        <button
          type="button"
          class={chosen.value ? "button" : "button primary"}
          onClick={() => void choose()}
        >
          {t.choose}
        </button>
        {others.map((port) => (
          <button
            key={port}
            type="button"
            class="button"
            onClick={() => {
              chosen.value = port;
            }}
          >
            {t.known(boardSettings(port).name)}
          </button>
        ))}
      </div>
      {relays.value.length > 0 && <p class="muted">{t.stayVisible}</p>}
    </div>
  );
}

/** The ports that the user allowed on an earlier visit. */
function useKnownPorts(): Signal<SerialPort[]> {
  const known = useSignal<SerialPort[]>([]);
  useEffect(() => {
    const serial = serialPorts();
    const update = () => {
      serial?.getPorts().then(
        (ports) => {
          known.value = ports;
        },
        () => undefined,
      );
    };
    update();
    serial?.addEventListener("connect", update);
    serial?.addEventListener("disconnect", update);
    return () => {
      serial?.removeEventListener("connect", update);
      serial?.removeEventListener("disconnect", update);
    };
  }, []);
  return known;
}

function PortForm(props: { port: Signal<SerialPort | undefined>; problem: Signal<string> }) {
  const port = props.port.value!;
  const settings = useSignal<BoardSettings>(boardSettings(port));
  const { name, baud } = settings.value;
  const isValid = isDeviceName(name);
  const connect = async () => {
    props.problem.value = "";
    props.port.value = undefined;
    try {
      await connectBoard(port, settings.value);
    } catch (error) {
      props.problem.value = t.cannotOpen(error instanceof Error ? error.message : String(error));
    }
  };
  return (
    <form
      class="control-card connect-form"
      onSubmit={(event) => {
        event.preventDefault();
        if (isValid) void connect();
      }}
    >
      <label>
        {t.name}
        <input
          class="field"
          value={name}
          maxLength={40}
          autocomplete="off"
          spellcheck={false}
          aria-invalid={!isValid}
          onInput={(event) => {
            settings.value = { ...settings.value, name: event.currentTarget.value };
          }}
        />
      </label>
      <label>
        {t.baud}
        <select
          class="field"
          value={baud}
          onChange={(event) => {
            settings.value = { ...settings.value, baud: Number(event.currentTarget.value) };
          }}
        >
          {BAUDS.map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
        </select>
      </label>
      <p class="muted">{isValid ? t.baudHint : t.nameRule}</p>
      <button type="submit" class="button primary" disabled={!isValid}>
        {t.connect}
      </button>
    </form>
  );
}

function RelayCard({ context, relay }: { context: PanelContext; relay: BoardRelay }) {
  // The counts change with every chunk; once a second is enough for the display.
  useTick(context, 1000);
  const state = relay.state.value;
  return (
    <section class="control-card connect-board" aria-label={relay.name}>
      <h2>{relay.name}</h2>
      <Badge level={LEVELS[state]}>{t.states[state]}</Badge>
      <p class="muted number">
        {t.counts(relay.baud, formatBytes(relay.receivedBytes), formatBytes(relay.sentBytes))}
      </p>
      {state === "away" && <p class="problem">{relay.problem.value || t.noServer}</p>}
      {state === "unplugged" && <p class="problem">{t.unpluggedText}</p>}
      <div class="connect-ports">
        <button
          type="button"
          class="button"
          disabled={state === "unplugged" || state === "opening"}
          onClick={() => relay.reset()}
        >
          {t.reset}
        </button>
        <button type="button" class="button" onClick={() => void disconnectBoard(relay)}>
          {t.disconnect}
        </button>
        <button type="button" class="button" onClick={() => context.open("boards")}>
          {t.showBoards}
        </button>
      </div>
    </section>
  );
}

export default preactPanel(ConnectPanel);

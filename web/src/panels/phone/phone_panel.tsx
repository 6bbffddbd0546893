// The sensors of the device that shows this page, as topics.
import { useSignal } from "@preact/signals";
import { type PhoneSensor, phoneLink, phoneName, renamePhone, sensors } from "../../phone/phone.ts";
import type { Problem } from "../../phone/sensor.ts";
import { formatBandwidth, formatRate } from "../../shell/format.ts";
import { EmptyState } from "../../shell/parts.tsx";
import { isDeviceName } from "../../store/device_name.ts";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";

const t = texts.phone;
const SIZES = [
  [320, 240],
  [640, 480],
  [1280, 720],
] as const;
const RATES = { imu: [10, 20, 50, 100], camera: [1, 2, 5, 10, 15, 30] } as const;

function PhonePanel({ context }: { context: PanelContext }) {
  const { info } = context.robot;
  const typed = useSignal(phoneName.value);
  if (!info.value) return null;
  if (info.value.metadata?.rights === "view") {
    return <EmptyState icon="phone" title={texts.connect.viewOnly} text={t.viewOnlyText} />;
  }
  const isValid = isDeviceName(typed.value);
  const link = phoneLink.value;
  const offset = link?.offset.value;
  return (
    <div class="phone">
      <p>{t.intro}</p>
      {!isSecureContext && <p class="problem">{t.insecureText}</p>}
      <label class="phone-name">
        {t.name}
        <input
          class="field"
          value={typed.value}
          maxLength={40}
          autocomplete="off"
          spellcheck={false}
          aria-invalid={!isValid}
          onInput={(event) => {
            typed.value = event.currentTarget.value;
          }}
          onChange={() => {
            if (isValid && typed.value !== phoneName.value) renamePhone(typed.value);
          }}
        />
      </label>
      {!isValid && <p class="problem">{texts.connect.nameRule}</p>}
      {sensors.map((each) => (
        <SensorCard key={each.sensor.id} context={context} of={each} />
      ))}
      {link && (
        <p class="muted number" role="status">
          {offset ? t.offset(offset.offsetMs, offset.roundTripMs / 2) : t.noOffset}
        </p>
      )}
      {link?.problem.value && <p class="problem">{link.problem.value}</p>}
      <p class="muted">{t.stayVisible}</p>
    </div>
  );
}

function SensorCard({ context, of }: { context: PanelContext; of: PhoneSensor }) {
  const { id, type } = of.sensor;
  // Rates change all the time.
  const now = useTick(context, 500);
  const isOn = of.isOn.value;
  const hertz = of.rate.hertz(now);
  const problem = of.problem.value;
  return (
    <section class="control-card phone-sensor" aria-label={t.sensors[id]}>
      <button
        type="button"
        class="switch"
        role="switch"
        aria-checked={isOn}
        aria-label={t.sensors[id]}
        onClick={() => of.toggle()}
      >
        <span class="switch-knob" />
        <span>{t.sensors[id]}</span>
      </button>
      <span class="number phone-rate">
        {hertz > 0 && `${formatRate(hertz)}, ${formatBandwidth(of.rate.bytesPerSecond(now))}`}
      </span>
      <p class="muted">
        <code>{of.topic}</code> {type}
      </p>
      <SensorSettings of={of} />
      {problem && (
        <p class="problem" role="alert">
          {problemText(id, problem)}
        </p>
      )}
    </section>
  );
}

function SensorSettings({ of }: { of: PhoneSensor }) {
  const { id } = of.sensor;
  const { hertz, width, height, isFront } = of.settings.value;
  if (id !== "imu" && id !== "camera") return null;
  return (
    <div class="phone-settings">
      <label>
        {t.rate}{" "}
        <select
          class="field"
          value={hertz}
          onChange={(event) => of.change({ hertz: Number(event.currentTarget.value) })}
        >
          {RATES[id].map((each) => (
            <option key={each} value={each}>
              {`${each} Hz`}
            </option>
          ))}
        </select>
      </label>
      {id === "camera" && (
        <>
          <label>
            {t.size}{" "}
            <select
              class="field"
              value={`${width}x${height}`}
              onChange={(event) => {
                const [w, h] = event.currentTarget.value.split("x").map(Number) as [number, number];
                of.change({ width: w, height: h });
              }}
            >
              {SIZES.map(([w, h]) => (
                <option key={w} value={`${w}x${h}`}>
                  {`${w} × ${h}`}
                </option>
              ))}
            </select>
          </label>
          <label>
            <input
              type="checkbox"
              checked={isFront}
              onChange={(event) => of.change({ isFront: event.currentTarget.checked })}
            />{" "}
            {t.front}
          </label>
        </>
      )}
    </div>
  );
}

function problemText(id: keyof typeof t.sensors, problem: Problem): string {
  return typeof problem === "string" ? t.problems[problem](t.sensors[id]) : problem.text;
}

export default preactPanel(PhonePanel);

// The parameters of the robot: read, search, edit.
import { type Signal, signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Parameter } from "../../connection/protocol.ts";
import { breakable, EmptyState, IconButton, SearchField } from "../../shell/parts.tsx";
import { byNode, describeParameters, type ParameterLimits } from "../../store/parameter_limits.ts";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { type Branch, parameterTree, readValue, valueText } from "./parameter_tree.ts";

interface ParametersSettings {
  search?: string;
}

// A robot description is a parameter of 100 kB, too large to edit in a field.
const MAX_EDITED = 2000;
// Texts with more lines scroll.
const MAX_ROWS = 8;
const REFRESH_MS = 5000;

/** The descriptions of parameters from their nodes; requested once for each. */
const limits = signal<ReadonlyMap<string, ParameterLimits>>(new Map());
const asked = new Set<string>();

/** Asks for the limits of parameters that are new. */
async function learnLimits({ robot }: PanelContext): Promise<void> {
  const services = robot.services.peek();
  const names = [...robot.parameters.values.peek().keys()].filter((each) => !asked.has(each));
  if (names.length === 0 || services.size === 0 || !robot.mayAct.peek()) return;
  // A node's services may be announced after its parameters: only those that were asked for are noted.
  for (const group of byNode(names, services).values()) for (const { full } of group) asked.add(full);
  const found = await describeParameters(robot.gateway, services, names);
  if (found.size > 0) limits.value = new Map([...limits.value, ...found]);
}

function ParametersPanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<ParametersSettings>;
  const { robot } = context;
  const failure = useSignal("");
  const search = settings.value.search ?? "";
  const isSeen = context.visible.value && robot.canCommand.value;
  const refresh = () =>
    robot.parameters
      .refresh()
      .then(() => {
        failure.value = "";
        return learnLimits(context);
      })
      .catch((error: unknown) => {
        failure.value = (error as Error).message;
      });
  useEffect(() => {
    if (!isSeen) return undefined;
    void refresh();
    // Only known parameters are watched; reading again finds new ones.
    const timer = setInterval(() => void refresh(), REFRESH_MS);
    return () => clearInterval(timer);
  }, [isSeen]);
  const tree = parameterTree(robot.parameters.values.value.values(), search);
  const isEmpty = tree.branches.length === 0 && tree.parameters.length === 0;
  return (
    <div class="parameters">
      <div class="toolbar">
        <SearchField
          value={search}
          label={texts.parameters.search}
          onInput={(text) => {
            settings.value = { search: text };
          }}
        />
        <IconButton icon="rotate" label={texts.parameters.refresh} onClick={() => void refresh()} />
      </div>
      {failure.value && <p class="problem">{failure.value}</p>}
      {isEmpty ? (
        <EmptyState icon="parameters" title={texts.parameters.none} text={texts.parameters.noneText} />
      ) : (
        <BranchRows branch={tree} context={context} isOpen />
      )}
    </div>
  );
}

function BranchRows({ branch, context, isOpen }: { branch: Branch; context: PanelContext; isOpen: boolean }) {
  const rows = (
    <div class="parameter-rows">
      {branch.parameters.map(({ name, parameter }) => (
        <Row key={parameter.name} name={name} parameter={parameter} context={context} />
      ))}
      {branch.branches.map((each) => (
        <BranchRows key={each.path} branch={each} context={context} isOpen={branch.branches.length < 12} />
      ))}
    </div>
  );
  if (branch.name === "") return rows;
  return (
    <details open={isOpen}>
      <summary>{branch.name}</summary>
      {rows}
    </details>
  );
}

function Row({ name, parameter, context }: { name: string; parameter: Parameter; context: PanelContext }) {
  const problem = useSignal("");
  const { value } = parameter;
  const set = async (next: unknown) => {
    try {
      await context.robot.parameters.set(parameter.name, next, parameter.type);
      problem.value = "";
    } catch (error) {
      problem.value = (error as Error).message;
    }
  };
  const text = valueText(value);
  // `roscore` ends its version with an end of line.
  const line = text.replace(/\n+$/, "");
  const known = limits.value.get(parameter.name);
  const isReadOnly = !context.robot.mayAct.value || known?.isReadOnly === true;
  const read = (text: string) => {
    try {
      void set(readValue(text, value));
    } catch (error) {
      problem.value = (error as Error).message;
    }
  };
  const title = [parameter.name, known?.description, known?.isReadOnly && texts.parameters.readOnly];
  return (
    <div class="parameter">
      {/* biome-ignore lint/a11y/noLabelWithoutControl: one of the fields below is the control. */}
      <label class="form-row" title={title.filter(Boolean).join("\n")}>
        <span class="form-name">{breakable(name)}</span>
        {typeof value === "boolean" ? (
          <input
            type="checkbox"
            checked={value}
            disabled={isReadOnly}
            onChange={(event) => void set(event.currentTarget.checked)}
          />
        ) : text.length > MAX_EDITED ? (
          <span class="parameter-long">{texts.parameters.tooLong(text.length)}</span>
        ) : typeof value === "number" && known?.min !== undefined ? (
          <RangeField value={value} limits={known} isReadOnly={isReadOnly} set={(next) => void set(next)} />
        ) : line.includes("\n") ? (
          // A field of one line would drop the ends of lines.
          <textarea
            rows={Math.min(text.split("\n").length, MAX_ROWS)}
            value={text}
            disabled={isReadOnly}
            onChange={(event) => read(event.currentTarget.value)}
          />
        ) : (
          <input
            type="text"
            value={line}
            disabled={isReadOnly}
            onChange={(event) => read(event.currentTarget.value + text.slice(line.length))}
          />
        )}
      </label>
      {problem.value && <p class="problem">{problem.value}</p>}
    </div>
  );
}

function RangeField(props: {
  value: number;
  limits: ParameterLimits;
  isReadOnly: boolean;
  set: (value: number) => void;
}) {
  const { min = 0, max = 0, step } = props.limits;
  const shared = {
    min,
    max,
    step: step || (Number.isInteger(min) && Number.isInteger(props.value) ? 1 : (max - min) / 500 || "any"),
    value: props.value,
    disabled: props.isReadOnly,
    onChange: (event: { currentTarget: HTMLInputElement }) => {
      const next = event.currentTarget.valueAsNumber;
      if (Number.isFinite(next)) props.set(next);
    },
  };
  return (
    <span class="parameter-range">
      <input type="range" {...shared} />
      <input type="number" aria-label={texts.parameters.range(min, max)} {...shared} step="any" />
    </span>
  );
}

export default preactPanel(ParametersPanel);

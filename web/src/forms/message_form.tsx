// A form for any message type: a field for each value, made from the definition.

import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { texts } from "../texts.ts";
import type { Field, Node, Primitive, StructNode } from "../wire/schema.ts";
import { typeName } from "../wire/schema.ts";
import { type Stamp, stampNow } from "../wire/stamp.ts";
import { type Choice, choicesOf } from "./choices.ts";
import { formatList, formatStamp, parseList, parseNumber, parseStamp } from "./numbers.ts";

/** The edited value: missing fields are zero. */
export type Draft = Record<string, unknown>;

interface FieldProps {
  node: Node;
  value: unknown;
  label: string;
  onChange: (value: unknown) => void;
}

// Deeper than any message; a deeper form would not fit on a screen.
const MAX_DEPTH = 8;
// A longer list of structures is too long to edit in a form.
const MAX_ITEMS = 50;

export function MessageForm(props: {
  type: StructNode;
  draft: Draft;
  onChange: (draft: Draft) => void;
  depth?: number;
}) {
  const { type, draft, onChange, depth = 0 } = props;
  if (depth > MAX_DEPTH) return null;
  return (
    <div class="form-fields">
      {type.fields.map((field) => (
        <FormRow
          key={field.name}
          field={field}
          choices={choicesOf(type, field)}
          value={draft[field.name]}
          depth={depth}
          onChange={(value) => onChange({ ...draft, [field.name]: value })}
        />
      ))}
    </div>
  );
}

function FormRow(props: {
  field: Field;
  choices: Choice[];
  value: unknown;
  depth: number;
  onChange: (value: unknown) => void;
}) {
  const { field, choices, value, depth, onChange } = props;
  const { node, name } = field;
  if (node.kind === "struct")
    return (
      <fieldset>
        <legend>
          {name} <span class="form-type">{node.name}</span>
        </legend>
        <MessageForm type={node} draft={(value ?? {}) as Draft} depth={depth + 1} onChange={onChange} />
      </fieldset>
    );
  if (node.kind === "array" && node.element.kind === "struct")
    return <StructList {...props} element={node.element} length={node.length} />;
  const row = (
    // biome-ignore lint/a11y/noLabelWithoutControl: ValueField is the control.
    <label class="form-row" title={field.comment || undefined}>
      <span class="form-name">{name}</span>
      <ValueField node={node} value={value} label={name} onChange={onChange} />
      <span class="form-type">{typeName(node)}</span>
    </label>
  );
  if (choices.length === 0) return row;
  return (
    <div class="form-choices">
      {row}
      <ChoiceField choices={choices} value={value} label={texts.forms.choice(name)} onChange={onChange} />
    </div>
  );
}

/** The named values of a field. Another value, such as a sum of flags, is typed into the field. */
function ChoiceField(props: {
  choices: Choice[];
  value: unknown;
  label: string;
  onChange: (value: unknown) => void;
}) {
  const { choices, value, label, onChange } = props;
  // Numbers of 64 bits are bigint, and a field that is not given is 0 or empty.
  const isChosen = (each: Choice) =>
    String(value ?? (typeof each.value === "string" ? "" : 0)) === String(each.value);
  return (
    <select
      class="form-choice"
      aria-label={label}
      value={choices.findIndex(isChosen)}
      onChange={(event) => {
        const chosen = choices[Number(event.currentTarget.value)];
        if (chosen !== undefined) onChange(chosen.value);
      }}
    >
      {!choices.some(isChosen) && <option value={-1}>{texts.forms.noChoice}</option>}
      {choices.map((each, index) => (
        <option key={each.name} value={index}>
          {each.name}
        </option>
      ))}
    </select>
  );
}

function StructList(props: {
  field: Field;
  value: unknown;
  depth: number;
  element: StructNode;
  length: number | undefined;
  onChange: (value: unknown) => void;
}) {
  const { field, element, length, onChange, depth } = props;
  const given = (Array.isArray(props.value) ? props.value : []) as Draft[];
  const items =
    length === undefined
      ? given
      : Array.from({ length: Math.min(length, MAX_ITEMS) }, (_, i) => given[i] ?? {});
  return (
    <fieldset>
      <legend>
        {field.name} <span class="form-type">{`${element.name}[${length ?? ""}]`}</span>
      </legend>
      {items.map((item, index) => (
        <div class="form-item" key={index}>
          <MessageForm
            type={element}
            draft={item}
            depth={depth + 1}
            onChange={(draft) => onChange(items.map((each, i) => (i === index ? draft : each)))}
          />
          {length === undefined && (
            <button
              type="button"
              class="button"
              onClick={() => onChange(items.filter((_, i) => i !== index))}
            >
              {texts.forms.remove}
            </button>
          )}
        </div>
      ))}
      {length === undefined && items.length < MAX_ITEMS && (
        <button type="button" class="button" onClick={() => onChange([...items, {}])}>
          {texts.forms.add}
        </button>
      )}
    </fieldset>
  );
}

/** The field of one value that is not a structure. An invalid text is kept and marked. */
function ValueField({ node, value, label, onChange }: FieldProps) {
  switch (node.kind) {
    case "primitive":
      if (node.type === "bool")
        return (
          <input
            type="checkbox"
            aria-label={label}
            checked={value === true}
            onChange={(event) => onChange(event.currentTarget.checked)}
          />
        );
      return <NumberField type={node.type} value={value} label={label} onChange={onChange} />;
    case "string":
      return (
        <input
          type="text"
          aria-label={label}
          value={typeof value === "string" ? value : ""}
          onInput={(event) => onChange(event.currentTarget.value)}
        />
      );
    case "time":
    case "duration":
      return <StampField kind={node.kind} value={value} label={label} onChange={onChange} />;
    case "array":
      return <ListField node={node} value={value} label={label} onChange={onChange} />;
    case "struct":
      return null;
  }
}

function NumberField(props: {
  type: Primitive;
  value: unknown;
  label: string;
  onChange: (value: unknown) => void;
}) {
  const { type, value, label, onChange } = props;
  const field = useFreshValidity(value);
  const read = (input: HTMLInputElement) => {
    const result = parseNumber(type, input.value);
    input.setCustomValidity(typeof result === "string" ? result : "");
    if (typeof result !== "string") onChange(result);
  };
  return (
    <input
      ref={field}
      type="text"
      inputMode={type.startsWith("u") ? "numeric" : "text"}
      aria-label={label}
      placeholder="0"
      value={value === undefined ? "" : String(value)}
      onChange={(event) => {
        read(event.currentTarget);
        event.currentTarget.reportValidity();
      }}
    />
  );
}

/** Clears the error mark of a field when it gets another value, for example a chosen one. */
function useFreshValidity(value: unknown): RefObject<HTMLInputElement | null> {
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.setCustomValidity(""), [value]);
  return field;
}

function StampField(props: Omit<FieldProps, "node"> & { kind: "time" | "duration" }) {
  const { kind, value, label, onChange } = props;
  const { sec = 0, nsec = 0 } = (value ?? {}) as Partial<Stamp>;
  const field = useFreshValidity(value);
  const read = (input: HTMLInputElement) => {
    const result = parseStamp(kind, input.value);
    input.setCustomValidity(typeof result === "string" ? result : "");
    if (typeof result !== "string") onChange(result);
    input.reportValidity();
  };
  return (
    <span class="form-stamp">
      <input
        ref={field}
        type="text"
        inputMode={kind === "time" ? "decimal" : "text"}
        aria-label={label}
        placeholder="0"
        value={sec === 0 && nsec === 0 ? "" : formatStamp({ sec, nsec })}
        onChange={(event) => read(event.currentTarget)}
      />
      {kind === "time" && (
        <button type="button" class="button" onClick={() => onChange(stampNow())}>
          {texts.forms.now}
        </button>
      )}
    </span>
  );
}

function ListField(props: FieldProps & { node: Node & { kind: "array" } }) {
  const { node, value, label, onChange } = props;
  const text = Array.isArray(value) ? formatList(value) : "";
  const read = (input: HTMLInputElement) => {
    const result = parseList(node.element, input.value);
    input.setCustomValidity(typeof result === "string" ? result : "");
    if (typeof result !== "string")
      onChange(result.length === 0 && node.length !== undefined ? undefined : result);
    input.reportValidity();
  };
  return (
    <input
      type="text"
      aria-label={label}
      placeholder={texts.forms.list}
      value={text}
      onChange={(event) => read(event.currentTarget)}
    />
  );
}

// Checks of a panel's settings. They come from links and from the browser's storage, which may contain anything.

/** Settings of one instance of a panel; must survive JSON. */
export type Settings = Record<string, unknown>;

export type SettingCheck = (value: unknown) => boolean;
/** By the name of a setting. */
export type SettingChecks = Readonly<Record<string, SettingCheck>>;

export const isText: SettingCheck = (value) => typeof value === "string";
export const isFlag: SettingCheck = (value) => typeof value === "boolean";
export const isTexts: SettingCheck = (value) => Array.isArray(value) && value.every(isText);
export const isNumber: SettingCheck = Number.isFinite;

/** One of a few values. */
export function isOneOf(values: readonly unknown[]): SettingCheck {
  return (value) => values.includes(value);
}

/** An object with these fields. */
export function hasFields(checks: SettingChecks): SettingCheck {
  return (value) =>
    typeof value === "object" &&
    value !== null &&
    Object.entries(checks).every(([name, check]) => check((value as Settings)[name]));
}

/** An object whose values, one for each topic, pass the check. */
export function isByTopic(check: SettingCheck): SettingCheck {
  return (value) => typeof value === "object" && value !== null && Object.values(value).every(check);
}

/** The settings that the panel has; the others are omitted. */
export function validSettings(settings: Settings | null | undefined, checks: SettingChecks = {}): Settings {
  return Object.fromEntries(
    Object.entries(settings ?? {}).filter(
      ([name, value]) => Object.hasOwn(checks, name) && checks[name]!(value),
    ),
  );
}

// JSON whose integers keep all digits: a parameter may have 64 bits, but a JavaScript number is exact only up to 2^53.

/** Supported by browsers since 2025; older ones round such integers. */
interface Source {
  readonly source?: string;
}
const rawJson = (JSON as { rawJSON?: (text: string) => unknown }).rawJSON;

/** Like JSON.parse; integers that a number cannot hold are bigint. Throws SyntaxError. */
export function parseExact(text: string): unknown {
  // TypeScript's type of JSON.parse does not have the reviver's third argument yet.
  const revive = (_: string, value: unknown, context?: Source) =>
    typeof value === "number" && !Number.isSafeInteger(value) && /^-?\d+$/.test(context?.source ?? "")
      ? BigInt(context?.source as string)
      : value;
  return JSON.parse(text, revive as (key: string, value: unknown) => unknown);
}

/** Like JSON.stringify; bigint becomes an integer. */
export function stringifyExact(value: unknown): string {
  return JSON.stringify(value, (_, each) =>
    typeof each === "bigint" ? (rawJson?.(String(each)) ?? Number(each)) : each,
  );
}

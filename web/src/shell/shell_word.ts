// Quotes a name for a command line: any node can offer a topic called `$(command)`.

const PLAIN = /^[\w/.:@%+,-][\w/.:@%+,=~-]*$/;

export function shellWord(name: string): string {
  return PLAIN.test(name) ? name : `'${name.replaceAll("'", `'\\''`)}'`;
}

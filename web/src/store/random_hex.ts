// The last part of a name, random so that two devices rarely have the same.

export function randomHex(): string {
  return crypto.getRandomValues(new Uint16Array(1))[0]!.toString(16).padStart(4, "0");
}

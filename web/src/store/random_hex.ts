// A name's last part that two devices hardly share.

export function randomHex(): string {
  return crypto.getRandomValues(new Uint16Array(1))[0]!.toString(16).padStart(4, "0");
}

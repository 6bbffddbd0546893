// The same as tf2_lookups.py, with the page's own buffer; its folder is the first argument.
import { readFileSync } from "node:fs";

const { TfBuffer } = await import(`${process.argv[2]}/tf_buffer.ts`);
const script = JSON.parse(readFileSync(0, "utf8"));
const tf = new TfBuffer();
for (const [parent, child, timeS, x, y, z, qx, qy, qz, qw, isStatic] of script.transforms) {
  tf.insert(parent, child, timeS, { translation: [x, y, z], rotation: [qx, qy, qz, qw] }, isStatic, 0);
}
const found = script.lookups.map(([target, source, timeS]: [string, string, number]) => {
  const { translation, rotation } = tf.lookup(target, source, timeS).transform;
  return [...translation, ...rotation];
});
console.log(JSON.stringify(found));

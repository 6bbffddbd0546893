// Refuses mesh files that a loader would expand to more than a browser has memory for.

/** A header and the number of triangles; then 50 bytes for each. */
const STL_HEAD_BYTES = 84;
const STL_TRIANGLE_BYTES = 50;
/** The name after the last triangle of a text file. */
const MAX_STL_REST = 10_000;

/** A thousand times as many as a robot's link has. */
const MAX_NODES = 100_000;
const MAX_DEPTH = 100;
// A tag has no `<` inside. Otherwise, the search would continue to the end of the file for each tag without an end.
const NODES = /<(\/?)node\b([^<>]*)>|<instance_node\b[^<>]*?\burl\s*=\s*["']#([^"']*)["']/g;
const ID = /\bid\s*=\s*["']([^"']*)["']/;

interface Content {
  own: number;
  instances: string[];
}

/**
 * Throws an Error if an STL file is incomplete.
 *
 * For a binary file, a loader allocates memory for the number of triangles in the header. In a text file, it searches
 * the whole rest of the file for each triangle or solid without an end.
 */
export function checkStl(bytes: Uint8Array): void {
  if (new TextDecoder().decode(bytes.subarray(0, 200)).trimStart().startsWith("solid")) {
    checkTextStl(new TextDecoder().decode(bytes));
    return;
  }
  const room = Math.floor((bytes.length - STL_HEAD_BYTES) / STL_TRIANGLE_BYTES);
  if (room < 0) throw new Error("it has no triangles");
  const count = new DataView(bytes.buffer, bytes.byteOffset).getUint32(STL_HEAD_BYTES - 4, true);
  if (count > room) throw new Error(`it ends after ${room} of ${count} triangles`);
}

function checkTextStl(text: string): void {
  const solids = text.split("endsolid");
  const isEnded = (solids.at(-1) ?? "").length <= MAX_STL_REST;
  if (!isEnded || solids.some((each) => each.length - each.lastIndexOf("endfacet") > MAX_STL_REST))
    throw new Error("a solid or a triangle has no end");
}

/** Throws an Error if a Collada file has too many nodes; a node counts as often as other nodes contain it. */
export function checkCollada(text: string): void {
  const file: Content = { own: 0, instances: [] };
  const inside = new Map<string, Content>();
  const open = [file];
  for (const [tag, end, attributes, url] of text.matchAll(NODES)) {
    if (url !== undefined) for (const each of open) each.instances.push(url);
    else if (end) open.pop();
    else {
      const node: Content = { own: 1, instances: [] };
      for (const each of open) each.own++;
      const id = ID.exec(attributes ?? "")?.[1];
      if (id !== undefined) inside.set(id, node);
      if (!tag.endsWith("/>")) open.push(node);
    }
    if (open.length > MAX_DEPTH) throw new Error(`its nodes have more than ${MAX_DEPTH} levels`);
    if (file.own + file.instances.length > MAX_NODES) throw new Error(`it has more than ${MAX_NODES} nodes`);
  }
  const sizes = new Map<Content, number>();
  const sizeOf = (content: Content | undefined): number => {
    if (content === undefined) return 0;
    const known = sizes.get(content);
    if (known !== undefined) return known;
    // A node that contains itself has no end.
    sizes.set(content, Number.POSITIVE_INFINITY);
    const size = content.instances.reduce((sum, each) => sum + sizeOf(inside.get(each)), content.own);
    if (size > MAX_NODES) throw new Error(`it has more than ${MAX_NODES} nodes`);
    sizes.set(content, size);
    return size;
  };
  sizeOf(file);
}

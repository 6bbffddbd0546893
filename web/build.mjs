// Builds the page into src/rostether/dashboard/page. The same sources give the same bytes.
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { basename, dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import * as esbuild from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const page = resolve(here, "../src/rostether/dashboard/page");
// The panels of most first pages: without them here, they are requested after the robot has listed its topics.
const FIRST_PANELS = ["boards_panel", "plots_panel", "controls_panel"];
// A phone on a weak robot network loads this before it shows anything.
const CORE_LIMIT_KB = 150;

/** Returns the built files by their path in the page, and what esbuild knows of them. */
async function build() {
  const separate = await bundle([]);
  // Each chunk is a request. All modules that several panels share become one chunk.
  const shared = Object.values(separate.metafile.outputs)
    .filter((each) => each.entryPoint === undefined)
    .flatMap((each) => Object.keys(each.inputs))
    .filter((path) => path.startsWith("src/"))
    .sort();
  const result = await bundle([importInPanels(shared)]);
  const files = new Map(result.outputFiles.map((each) => [relative(page, each.path), each.contents]));
  files.set("index.html", readFileSync(join(here, "src/index.html")));
  files.set("licenses.txt", Buffer.from(licenses(Object.keys(result.metafile.inputs))));
  return withStableNames(files, result.metafile.outputs);
}

/** Lets every panel import these modules: esbuild puts modules that the same entry points use into one chunk. */
function importInPanels(paths) {
  const imports = paths.map((path) => `import ${JSON.stringify(join(here, path))};\n`).join("");
  return {
    name: "import-in-panels",
    setup(build) {
      build.onLoad({ filter: /\/src\/(main|panels\/\w+\/\w+_panel)\.tsx$/ }, ({ path }) => ({
        contents: imports + readFileSync(path, "utf8"),
        loader: "tsx",
      }));
    },
  };
}

function bundle(plugins) {
  return esbuild.build({
    plugins,
    absWorkingDir: here,
    entryPoints: { app: "src/main.tsx", style: "src/style/main.css" },
    outdir: page,
    bundle: true,
    splitting: true,
    format: "esm",
    target: "es2022",
    minify: true,
    write: false,
    metafile: true,
    legalComments: "none",
    jsx: "automatic",
    jsxImportSource: "preact",
    chunkNames: "chunks/[name]-[hash]",
    assetNames: "assets/[name]-[hash]",
    loader: { ".png": "file", ".svg": "file" },
    logLevel: "warning",
  });
}

/**
 * Names each chunk by its main module instead of its hash: a change of one module then changes few files.
 * The server sends a tag of each file's version, so that browsers notice new ones.
 */
function withStableNames(files, outputs) {
  const paths = Object.keys(outputs)
    .filter((path) => /\/chunks\/[^/]+\.js$/.test(path))
    .sort(byMainModule);
  const renamed = new Map();
  const taken = new Set();
  for (const path of paths) {
    let name = basename(mainModule(path)).replace(/\.\w+$/, "");
    for (let number = 2; taken.has(name); number++) name = `${name.replace(/-\d+$/, "")}-${number}`;
    taken.add(name);
    renamed.set(basename(path), `${name}.js`);
  }
  function mainModule(path) {
    const { entryPoint, inputs } = outputs[path];
    // The largest; of two as large the first by name.
    const largest = Object.entries(inputs).sort(
      ([a, { bytesInOutput: x }], [b, { bytesInOutput: y }]) => y - x || (a < b ? -1 : 1),
    )[0];
    return entryPoint ?? largest?.[0] ?? "empty";
  }
  function byMainModule(a, b) {
    const [x, y] = [mainModule(a), mainModule(b)];
    return x === y ? (a < b ? -1 : 1) : x < y ? -1 : 1;
  }
  const pattern = new RegExp([...renamed.keys()].map((each) => each.replaceAll(".", "\\.")).join("|"), "g");
  const rename = (text) => text.replace(pattern, (old) => renamed.get(old));
  const stable = new Map();
  for (const [path, contents] of files) {
    const isScript = path.endsWith(".js");
    stable.set(
      rename(path),
      isScript ? Buffer.from(rename(Buffer.from(contents).toString("utf8"))) : contents,
    );
  }
  const renamedOutputs = Object.fromEntries(
    Object.entries(outputs).map(([path, each]) => [
      rename(path),
      { ...each, imports: each.imports.map((one) => ({ ...one, path: rename(one.path) })) },
    ]),
  );
  return { files: stable, outputs: renamedOutputs };
}

/** Returns the licenses of the packages whose code is in the page, as they ask for. */
function licenses(inputs) {
  const names = inputs.map((path) => /^node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(path)?.[1]).filter(Boolean);
  const parts = [...new Set(names)].sort().map((name) => {
    const folder = join(here, "node_modules", name);
    const { version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    const own = readdirSync(folder).find((each) => /^licen[cs]e/i.test(each));
    // Some packages only name their license; LICENSES has those texts.
    const file = own ? join(folder, own) : join(here, `../LICENSES/${license}.txt`);
    return `${name} ${version}\n\n${readFileSync(file, "utf8").trim()}\n`;
  });
  return parts.join(`\n${"-".repeat(80)}\n\n`);
}

/** Returns the files that the browser loads before it shows the page. */
function coreFiles(outputs) {
  const byPath = Object.fromEntries(
    Object.entries(outputs).map(([path, each]) => [relative(page, resolve(here, path)), each]),
  );
  const core = new Set(["index.html", "style.css"]);
  const add = (path) => {
    if (core.has(path)) return;
    core.add(path);
    for (const each of byPath[path].imports) {
      if (each.kind === "import-statement") add(relative(page, resolve(here, each.path)));
    }
  };
  add("app.js");
  for (const name of FIRST_PANELS) add(`chunks/${name}.js`);
  return core;
}

function kilobytes(contents) {
  return gzipSync(contents, { level: 9 }).length / 1000;
}

/** Returns the page with its core's chunks named, so that the browser loads them at once. */
function withPreloads(html, core) {
  const links = [...core]
    .filter((path) => path.endsWith(".js"))
    .sort()
    .map((path) => `<link rel="modulepreload" href="${path}" />`);
  return Buffer.from(html.toString("utf8").replace("<!-- preloads -->", links.join("\n    ")));
}

const { files, outputs } = await build();
const core = coreFiles(outputs);
files.set("index.html", withPreloads(files.get("index.html"), core));
let coreSize = 0;
for (const [path, contents] of [...files].sort(([a], [b]) => (a < b ? -1 : 1))) {
  const size = kilobytes(contents);
  if (core.has(path)) coreSize += size;
  console.log(`${size.toFixed(1).padStart(8)} kB gzip  ${path}${core.has(path) ? "  (core)" : ""}`);
}
console.log(`${coreSize.toFixed(1).padStart(8)} kB gzip  core, of at most ${CORE_LIMIT_KB}`);
if (coreSize > CORE_LIMIT_KB) {
  console.error("The core of the page is too large: load a part of it on first use with import().");
  process.exit(1);
}
if (process.argv.includes("--check")) {
  const there = readdirSync(page, { recursive: true, withFileTypes: true })
    .filter((each) => each.isFile() && !each.name.endsWith(".py"))
    .map((each) => relative(page, join(each.parentPath, each.name)));
  const stale = [...files].filter(
    ([path, contents]) => !there.includes(path) || !readFileSync(join(page, path)).equals(contents),
  );
  const extra = there.filter((path) => !files.has(path));
  if (stale.length || extra.length) {
    const names = [...stale.map(([path]) => path), ...extra].join(", ");
    console.error(`The built page differs from its sources: run \`make web\` and commit. Files: ${names}`);
    process.exit(1);
  }
} else {
  rmSync(page, { recursive: true, force: true });
  for (const [path, contents] of files) {
    mkdirSync(dirname(join(page, path)), { recursive: true });
    writeFileSync(join(page, path), contents);
  }
}

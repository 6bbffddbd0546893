// Serves the built page for development: node serve.mjs [PORT], then open http://localhost:PORT/?ws=ws://localhost:8765
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const page = join(dirname(fileURLToPath(import.meta.url)), "../src/rostether/dashboard/page");
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".png": "image/png" };
const csp =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; " +
  "connect-src 'self' ws: wss:; worker-src 'self' blob:; manifest-src 'self'; frame-ancestors 'none'";
const port = Number(process.argv[2] ?? 8080);
createServer(async (request, response) => {
  const path = normalize(new URL(request.url, "http://localhost").pathname);
  try {
    const contents = await readFile(join(page, path === "/" ? "index.html" : path));
    const type = types[extname(path)] ?? (path === "/" ? "text/html" : "application/octet-stream");
    response.writeHead(200, {
      "Content-Type": type,
      "Content-Security-Policy": csp,
      "Cache-Control": "no-store",
    });
    response.end(contents);
  } catch {
    response.writeHead(404).end();
  }
}).listen(port, "127.0.0.1", () => console.log(`http://localhost:${port}/`));

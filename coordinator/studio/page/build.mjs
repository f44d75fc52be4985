// Builds the page: one HTML file with script and style inside, written to built/page.html and committed, so that nobody
// who builds Coppice needs Node. `node build.mjs --check` builds and compares instead: CI fails on a difference.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync, mkdirSync } from "node:fs";
import { gzipSync } from "node:zlib";

const kMostBytes = 250_000; // of the page without data: says when a library has become too heavy
const target = new URL("built/page.html", import.meta.url);

const bundle = async (entry) => {
  const result = await build({
    entryPoints: [new URL(entry, import.meta.url).pathname],
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2022",
    charset: "ascii",
    legalComments: "eof",
    jsx: "automatic",
    jsxImportSource: "preact",
    write: false,
  });
  return result.outputFiles[0].text;
};

// What an inline script or style element must not hold.
const inline = (text) => text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--").trim();
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

const script = inline(await bundle("src/main.tsx"));
const style = (await bundle("src/style.css")).trim();
// frame-ancestors works in a header only; the studio's server sends it.
const policy = [
  "default-src 'none'",
  `script-src ${hash(script)}`,
  `style-src ${hash(style)}`,
  "img-src data: blob:",
  "connect-src coppice-connect",
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");
const page = `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="referrer" content="no-referrer">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<title>Coppice</title>
<link rel="icon" href="data:,">
<style>${style}</style>
</head>
<body>
<div id="page"><p>This page needs JavaScript.</p></div>
<!--coppice-data-->
<script>${script}</script>
</body>
</html>
`;
if (page.length > kMostBytes) {
  console.error(`built/page.html would have ${page.length} bytes: at most ${kMostBytes} are allowed`);
  process.exit(1);
}
if (process.argv.includes("--check")) {
  if (readFileSync(target, "utf8") !== page) {
    console.error("built/page.html is not what src/ gives: run 'npm run build' in coordinator/studio/page and commit it");
    process.exit(1);
  }
  console.log("built/page.html is what src/ gives");
} else {
  mkdirSync(new URL("built/", import.meta.url), { recursive: true });
  writeFileSync(target, page);
  console.log(`built/page.html: ${page.length} bytes, ${gzipSync(page).length} compressed`);
}

// Builds the viewer into the Python package: `node build.mjs`.
import { build } from "esbuild";
import { cp, rm } from "node:fs/promises";

const out = new URL("../src/frontage/viewer/program/", import.meta.url).pathname;
await rm(out, { recursive: true, force: true });
await build({
  entryPoints: { viewer: "src/main.ts", style: "src/style.css" },
  outdir: out,
  bundle: true,
  splitting: true,
  format: "esm",
  target: ["es2022"],
  minify: true,
  legalComments: "linked",
  chunkNames: "[name]-[hash]",
  logLevel: "warning",
});
await cp(new URL("index.html", import.meta.url), `${out}/index.html`);

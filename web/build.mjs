// Builds the viewer into the Python package: `node build.mjs`.
import { build } from "esbuild";
import { cp, readdir, readFile, rm, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const out = here("../src/frontage/viewer/program/");
await rm(out, { recursive: true, force: true });
const { metafile } = await build({
  absWorkingDir: here("."),
  entryPoints: { viewer: "src/main.ts", style: "src/style.css" },
  outdir: out,
  bundle: true,
  splitting: true,
  format: "esm",
  target: ["es2022"],
  minify: true,
  legalComments: "none",
  chunkNames: "[name]-[hash]",
  metafile: true,
  logLevel: "warning",
});
await writeFile(`${out}licences.txt`, await licences(Object.keys(metafile.inputs)));
// The page comes last: it tells that everything is there.
await cp(here("index.html"), `${out}index.html`);

// The licences of the packages whose code is in the program.
async function licences(inputs) {
  const names = new Set(inputs.map((path) => /^node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(path)?.[1]).filter(Boolean));
  const texts = [...names].sort().map(async (name) => {
    const folder = here(`node_modules/${name}/`);
    const about = JSON.parse(await readFile(`${folder}package.json`, "utf8"));
    const file = (await readdir(folder)).find((entry) => /^licen[cs]e/i.test(entry));
    if (!file) throw new Error(`${name} has no licence text`);
    return `${name} ${about.version} (${about.license})\n\n${await readFile(folder + file, "utf8")}`;
  });
  return (await Promise.all(texts)).join(`\n${"-".repeat(80)}\n\n`);
}

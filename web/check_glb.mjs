// Prints the findings of the glTF validator of Khronos on binary files as JSON: `node check_glb.mjs FILE ...`.
import { readFile } from "node:fs/promises";
import validator from "gltf-validator";

const findings = {};
for (const path of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(await readFile(path)));
  findings[path] = issues.messages;
}
console.log(JSON.stringify(findings));

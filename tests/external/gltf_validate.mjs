// The Khronos validator over binary glTF files: `node gltf_validate.mjs FILE.glb ...` prints one JSON object a line.
import { readFile } from "node:fs/promises";
import path from "node:path";
import validator from "gltf-validator";

for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: path.basename(file),
    format: "glb",
    maxIssues: 100,
  });
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  const summary = { file, errors: numErrors, warnings: numWarnings, infos: numInfos, hints: numHints, messages };
  process.stdout.write(JSON.stringify(summary) + "\n");
}

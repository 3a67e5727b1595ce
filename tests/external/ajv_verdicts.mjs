// The verdict of ajv on JSON instances: `node ajv_verdicts.mjs REQUEST.json`.
//
// The request has `schemas` (each with its $id) and `instances`, a list of {schema: $id, instance}. Printed is the
// list of verdicts in the same order: {valid, errors: [{instancePath, keyword}]}. In strict mode ajv refuses a schema with
// a keyword that it does not know. Types may be stated by the schema that refers, so strictTypes is off.
import { readFile } from "node:fs/promises";
import Ajv2020 from "ajv/dist/2020.js";

const request = JSON.parse(await readFile(process.argv[2], "utf8"));
const ajv = new Ajv2020({ strictSchema: true, strictTypes: false, strictTuples: true, allErrors: true });
for (const schema of request.schemas) ajv.addSchema(schema);

const verdicts = request.instances.map(({ schema, instance }) => {
  const validate = ajv.getSchema(schema);
  if (!validate) throw new Error(`no schema has the $id ${schema}`);
  const valid = validate(instance);
  const errors = (validate.errors ?? []).map(({ instancePath, keyword }) => ({ instancePath, keyword }));
  return { valid, errors };
});
process.stdout.write(JSON.stringify(verdicts) + "\n");

// The validator of glTF finds no fault in the models, and they move as the mechanism does.
//   node test_gltf.mjs FLEXOPT SOURCE WORK
import {execFileSync} from "node:child_process";
import {readFileSync, rmSync} from "node:fs";
import {join} from "node:path";

const [flexopt, source, work] = process.argv.slice(2);
let validator;
try {
  validator = (await import("gltf-validator")).default;
} catch {
  console.log("no gltf-validator: npm ci in tests/results/export");
  process.exit(77);
}

let failed = 0;
function check(what, holds) {
  if (holds) return;
  console.log(`wrong: ${what}`);
  ++failed;
}
const near = (a, b, tolerance) => Math.abs(a - b) <= tolerance;

async function faults(bytes) {
  const {issues} = await validator.validateBytes(new Uint8Array(bytes));
  return issues;
}

/// The document of a .glb, and numbers of its accessors.
function read(bytes) {
  const length = bytes.readUInt32LE(12), document = JSON.parse(bytes.subarray(20, 20 + length).toString());
  const begin = 20 + length + 8;
  const numbers = (index) => {
    const accessor = document.accessors[index], view = document.bufferViews[accessor.bufferView];
    const width = {SCALAR: 1, VEC3: 3, VEC4: 4}[accessor.type];
    return Array.from({length: accessor.count * width}, (_, k) => bytes.readFloatLE(begin + view.byteOffset + 4 * k));
  };
  return {document, numbers};
}

rmSync(work, {recursive: true, force: true});
for (const [name, ...at] of [["parallel_guide"], ["parallel_guide", "--at", "10 mm"], ["cross_hinge"], ["folded_guide"],
  ["wire_flexure"], ["curved_hinge"], ["cantilever"], ["xy_stage"], ["notch_beam"]]) {
  execFileSync(flexopt, ["export", join(source, "designs/jobs", `${name}.json`), "--format", "gltf", "--out", work, ...at]);
  const issues = await faults(readFileSync(join(work, `${name}.glb`)));
  check(`${name}: ${JSON.stringify(issues.messages)}`, issues.numErrors === 0 && issues.numWarnings === 0);
}
execFileSync(flexopt, ["export", join(source, "tests/results/export/elastic_guide.json"), "--format", "gltf", "--out", work]);
const elastic = readFileSync(join(work, "elastic_guide.glb")), {messages, numErrors, numWarnings} = (await faults(elastic));
check(`elastic bodies: ${JSON.stringify(messages)}`, numErrors === 0 && numWarnings === 0);
check("elastic bodies bend as morph targets", ["end_effector", "foot"].every((name) =>
  read(elastic).document.meshes.find((mesh) => mesh.name === name)?.weights.length === 3));

// the validator can find faults
const whole = readFileSync(join(work, "parallel_guide.glb")), broken = Buffer.from(whole);
broken.write("VEC2", broken.indexOf("VEC3"));
check("a broken file passes", (await faults(broken)).numErrors > 0);

// the end-effector of the guide moves by 20 mm, and so do the tips of its leaves
const {document, numbers} = read(whole);
const {channels, samplers} = document.animations[0];
const body = document.nodes.findIndex((node) => node.name === "body end_effector");
const places = numbers(samplers[channels.find((c) => c.target.node === body && c.target.path === "translation").sampler].output);
const highest = Math.max(...places.filter((_, k) => k % 3 === 1));
check(`the body moves by ${highest}`, near(highest, 0.02, 1e-6));
check("it comes back", near(places.at(-2), 0, 1e-6));
const times = numbers(samplers[0].input);
check("time grows", times.every((t, k) => k === 0 || t > times[k - 1]));
const leaf = document.meshes[document.nodes.find((node) => node.name === "leaf leaf +y").mesh];
const {attributes, targets} = leaf.primitives[0];
const rest = numbers(attributes.POSITION), last = numbers(targets.at(-1).POSITION);
check("one target a stroke point", targets.length === 11);
let tip = 0;
for (let k = 0; k < rest.length; k += 3) if (rest[k] + last[k] > rest[tip] + last[tip]) tip = k;
// it was exported at 10 mm, from where the last shape is as far again
check(`the tip moves by ${last[tip + 1]}`, near(last[tip + 1], 0.01, 1e-4));
process.exit(failed ? 1 : 0);

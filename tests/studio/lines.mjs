// Prints the lines of scenes that come as JSON.

import { readFileSync } from "node:fs";

import { cppLines, pythonLines } from "../../build/studio/modules/lines.js";

const scenes = JSON.parse(readFileSync(0, "utf8"));
console.log(JSON.stringify(scenes.map((scene) => ({ cpp: cppLines(scene), python: pythonLines(scene) }))));

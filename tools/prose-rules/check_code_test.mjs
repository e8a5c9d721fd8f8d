// node check_code_test.mjs: what the check of the code's words finds, and what it lets pass.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { codeFindings, readTerms } from "./check_code.mjs";
import { languageOf, rawPieces } from "./code_pieces.mjs";

const terms = readTerms(`
rules:
  - expected: reject
    words: [refuse, refused]
    allowed:
      - match: refused
        why: a key
        files: [report.cpp]
  - expected: sigma
    names: [deviation]
    text: ['(?<!\\bstandard )\\bdeviations?\\b']
  - expected: initialise
    identifiers: ['begin_landmark\\w*']
  - expected: standstill
    text: ['\\bat rest\\b']
    allowed:
      - match: '"at rest"'
        why: a key
`);
const found = (file, text) => codeFindings(file, text, terms).map(({ line, word }) => `${line} ${word}`);

// Parts of identifiers, in every style.
assert.deepEqual(found("a.cpp", "int refuse_gap, kRefused;\nbool isRefusedAt(int REFUSE);"),
  ["1 refuse_gap", "1 kRefused", "2 isRefusedAt", "2 REFUSE"]);
assert.deepEqual(found("a.cpp", "begin_landmarks(x.begin(), x.end()); auto rest = all.rest();"),
  ["1 begin_landmarks"]);
// Strings and comments, also over several lines and literals.
assert.deepEqual(found("a.cpp", '// It is\n/// refused.\nf("a standard "\n  "deviation", "a deviation");'),
  ["2 refused", "4 deviation"]);
assert.deepEqual(found("a.cpp", "// at\n// rest\n/* a standard\n * deviation */"), ["1 at rest"]);
assert.deepEqual(found("a.cpp", 'R"(refused "x" refuse)" + \'"\' + 1\'000 + "refused"'),
  ["1 refused", "1 refuse", "1 refused"]);
assert.deepEqual(found("a.py", '"""Refused\n"""\nrefuse = f(\'at rest\')  # refused'),
  ["1 Refused", "3 refuse", "3 at rest", "3 refused"]);
assert.deepEqual(found("a.ts", "const a = `refused ${refuse(`x ${b}`)} at rest`, c = d / e / 2; // refuse"),
  ["1 refused", "1 refuse", "1 at rest", "1 refuse"]);
assert.deepEqual(found("a.mjs", "x.replace(/\"refused/g, 'y'); const [q] = 'it\\'s'; refuse();"),
  ["1 refused", "1 refuse"]);
// Exceptions hold for a whole identifier, in their files.
assert.deepEqual(found("src/report.cpp", "refused; was_refused;"), ["1 was_refused"]);
assert.deepEqual(found("a.cpp", 'f("at rest"); // at rest'), ["1 at rest"]);
assert.throws(() => readTerms("rules: [{expected: a, words: [b], allowed: [{match: c}]}]"), /why/);
assert.throws(() => readTerms("rules: [{words: [b]}]"), /expected/);
// What is no source has no findings; a script is one by its first line.
assert.deepEqual(found("a.csv", "refused"), []);
assert.equal(languageOf("tools/study", "#!/usr/bin/env python3\n"), "python");
// Pieces are the whole text.
const here = dirname(fileURLToPath(import.meta.url));
for (const file of ["check_code.mjs", "code_pieces.mjs", "check_code_test.mjs"]) {
  const text = readFileSync(resolve(here, file), "utf8");
  assert.equal(rawPieces(text, "typescript").map((piece) => piece.text).join(""), text, file);
}

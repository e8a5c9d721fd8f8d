// node check_code.mjs [FILE...]: words that the glossary replaces, in the identifiers, strings and comments of
// these sources, or of all sources of the tree; one finding a line, and exit code 1 if there are any. The words
// and the exceptions with their reasons are in code_terms.yml.
import { execFileSync } from "node:child_process";
import { existsSync, lstatSync, readFileSync } from "node:fs";
import { basename, dirname, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import yaml from "js-yaml";

import { languageOf, pieces } from "./code_pieces.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const root = resolve(here, "../..");

/** The rules of a file as code_terms.yml, ready for use. Throws if one lacks what it needs. */
export function readTerms(text) {
  return yaml.load(text).rules.map((rule) => {
    if (!rule.expected || !(rule.words || rule.names || rule.identifiers || rule.text)) {
      throw new Error("a rule needs 'expected', and 'words', 'names', 'identifiers' or 'text': " +
        JSON.stringify(rule));
    }
    const allowed = (rule.allowed ?? []).map(({ match, why, files }) => {
      if (!match || !why) throw new Error(`an exception needs 'match' and 'why': ${JSON.stringify(match)}`);
      const inText = new RegExp(match.replaceAll(" ", "\\s+"), "gi");
      return { match, whole: new RegExp(`^(?:${match})$`), inText, files, used: false };
    });
    const words = new Set(rule.words ?? []);
    return {
      expected: rule.expected,
      inName: new Set([...words, ...(rule.names ?? [])]),
      identifiers: (rule.identifiers ?? []).map((pattern) => new RegExp(`^(?:${pattern})$`)),
      inText: [...(words.size ? [`\\b(?:${[...words].join("|")})\\b`] : []), ...(rule.text ?? [])]
        .map((pattern) => new RegExp(pattern.replaceAll(" ", "\\s+"), "gi")),
      allowed,
    };
  });
}

const parts = /[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+/g;
// In a text, a name has an underscore or capitals inside; other words there are English.
const nameInText = /\b(?:[A-Za-z]\w*_\w*|_\w+|[a-z]+[A-Z]\w*|[A-Z][a-z]+[A-Z]\w*)\b/g;
const nameIn = { code: /[A-Za-z_]\w*/g, comment: nameInText, string: nameInText };

const isOf = (exception, file) => !exception.files || exception.files.includes(basename(file));

function allows(rule, file, name) {
  const exception = rule.allowed.find((one) => isOf(one, file) && one.whole.test(name));
  if (exception) exception.used = true;
  return Boolean(exception);
}

/** The text without what is allowed there: of the same length and lines. */
function without(rule, file, text) {
  for (const exception of rule.allowed.filter((one) => isOf(one, file))) {
    text = text.replace(exception.inText, (match) => {
      exception.used = true;
      return match.replace(/[^\n]/g, " ");
    });
  }
  return text;
}

/** [{line, word, expected}] of a source text. */
export function codeFindings(file, text, rules, language = languageOf(file, text)) {
  const found = [], known = new Map();
  const ofName = (name) => {
    if (!known.has(name)) {
      const words = (name.match(parts) ?? []).map((part) => part.toLowerCase());
      known.set(name, rules.filter(({ inName, identifiers }) =>
        words.some((word) => inName.has(word)) || identifiers.some((pattern) => pattern.test(name))));
    }
    return known.get(name);
  };
  for (const piece of language ? pieces(text, language) : []) {
    const lineAt = (index) => piece.line + piece.text.slice(0, index).split("\n").length - 1;
    for (const m of piece.text.matchAll(nameIn[piece.kind])) {
      const rule = ofName(m[0]).find((one) => !allows(one, file, m[0]));
      if (rule) found.push({ line: lineAt(m.index), word: m[0], expected: rule.expected });
    }
    if (piece.kind === "code") continue;
    for (const rule of rules) {
      if (!rule.inText.some((pattern) => piece.text.search(pattern) >= 0)) continue;
      const rest = without(rule, file, piece.text);
      for (const pattern of rule.inText) {
        for (const m of rest.matchAll(pattern)) {
          found.push({ line: lineAt(m.index), word: m[0].replace(/\s+/g, " "), expected: rule.expected });
        }
      }
    }
  }
  return found.sort((a, b) => a.line - b.line);
}

function sources() {
  const listed = execFileSync("git", ["ls-files", "-z", "-co", "--exclude-standard"],
    { cwd: root, encoding: "utf8" });
  return listed.split("\0").filter(Boolean).map((file) => resolve(root, file));
}

// The check, its test and its rules name the words.
const own = /^tools\/prose-rules\//;

function main(given) {
  const rules = readTerms(readFileSync(resolve(here, "code_terms.yml"), "utf8"));
  let checked = 0, count = 0;
  const report = (where, text) => {
    console.log(`${where}: ${text}`);
    ++count;
  };
  for (const file of given.length ? given.map((one) => resolve(one)) : sources()) {
    const name = relative(root, file);
    if (own.test(name) || !existsSync(file) || !lstatSync(file).isFile()) continue;
    const script = !/\.\w+$/.test(name);
    if (!script && !languageOf(name)) continue;
    const text = readFileSync(file, "utf8");
    if (!languageOf(name, text)) continue;
    ++checked;
    for (const { line, word, expected } of codeFindings(name, text, rules)) {
      report(`${name}:${line}`, `${word} -> ${expected}`);
    }
  }
  if (!given.length) {
    for (const { match, used } of rules.flatMap((rule) => rule.allowed)) {
      if (!used) report("tools/prose-rules/code_terms.yml", `the exception ${match} allows nothing: remove it`);
    }
  }
  console.log(`words of the code: ${checked} sources, ${count} findings`);
  process.exitCode = count ? 1 : 0;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) main(process.argv.slice(2));

// node check.mjs FILE...: findings in the prose of Markdown files, one a line; exit code 1 if there are any.
// markdownlint checks the lines; textlint checks sentences, the passive and words. An exception is a comment
// of theirs, e.g. <!-- textlint-disable prh -->, with its reason on the same line: <!-- why: ... -->.
import { readFile } from "node:fs/promises";
import { dirname, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { TextlintKernel } from "@textlint/kernel";
import markdown from "@textlint/textlint-plugin-markdown";
import { lint } from "markdownlint/promise";
import comments from "textlint-filter-rule-comments";
import maxWordCount from "textlint-rule-en-max-word-count";
import prh from "textlint-rule-prh";

import { passiveShare } from "./rules/passive_share.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const root = resolve(here, "../..");
const terms = resolve(here, "terms.yml");
const glossary = resolve(root, "docs/glossary.md");

// A line may be longer where it cannot be broken, in tables and in code.
const markdownlintConfig = {
  default: false,
  MD013: { line_length: 100, tables: false, code_blocks: false },
  MD031: true, // blank lines around code
  MD032: true, // and around lists: without them the site shows a paragraph
  MD056: true, // as many cells in each row of a table
};

const everywhere = { checkLink: true, checkBlockQuote: true, checkEmphasis: true, checkHeader: true };

const rules = [
  { ruleId: "sentence", rule: maxWordCount.default ?? maxWordCount, options: { max: 30 } },
  { ruleId: "passive", rule: passiveShare, options: { max: 0.2 } },
  { ruleId: "prh", rule: prh.default ?? prh, options: { rulePaths: [terms], ...everywhere } },
];

async function textlintFindings(file, text) {
  const result = await new TextlintKernel().lintText(text, {
    filePath: file,
    ext: ".md",
    plugins: [{ pluginId: "markdown", plugin: markdown.default ?? markdown }],
    filterRules: [{ ruleId: "comments", rule: comments.default ?? comments }],
    // The glossary lists the words.
    rules: rules.filter(({ ruleId }) => file !== glossary || ruleId !== "prh"),
  });
  return result.messages.map(({ line, ruleId, message }) => ({
    line,
    rule: ruleId,
    message: message.replace(" => ", ": better "),
  }));
}

async function markdownlintFindings(text) {
  const { page } = await lint({ strings: { page: text }, config: markdownlintConfig });
  return page.map(({ lineNumber, ruleNames, ruleDescription, errorDetail }) => ({
    line: lineNumber,
    rule: ruleNames[0],
    message: [ruleDescription, errorDetail].filter(Boolean).join(": "),
  }));
}

function unexplainedExceptions(text) {
  return text.split("\n").flatMap((line, index) =>
    /<!-- *(textlint|markdownlint)-(?!enable)/.test(line) && !/<!-- why: .+-->/.test(line)
      ? [{ line: index + 1, rule: "exception", message: "an exception without <!-- why: ... -->" }]
      : []);
}

/** The phrases of the glossary's column "avoid" that terms.yml does not name. */
async function unknownToTerms() {
  const known = await readFile(terms, "utf8");
  let avoid = false;
  return (await readFile(glossary, "utf8")).split("\n").flatMap((line, index) => {
    const cells = line.split("|").slice(1, -1).map((cell) => cell.trim());
    if (cells.length !== 3) avoid = false;
    else if (cells[2] === "avoid") avoid = true;
    else if (avoid && !/^-+$/.test(cells[2])) {
      return cells[2].split(/, */).filter((phrase) => phrase && !known.includes(`"${phrase}"`))
        .map((phrase) => `tools/prose-rules/terms.yml lacks "${phrase}"`)
        .map((message) => ({ line: index + 1, rule: "glossary", message }));
    }
    return [];
  });
}

let count = 0;
const files = process.argv.slice(2).map((file) => resolve(file));
for (const file of files) {
  const text = await readFile(file, "utf8");
  const findings = [
    ...(await markdownlintFindings(text)),
    ...(await textlintFindings(file, text)),
    ...unexplainedExceptions(text),
    ...(file === glossary ? await unknownToTerms() : []),
  ];
  findings.sort((a, b) => a.line - b.line);
  for (const { line, rule, message } of findings) {
    console.log(`${relative(root, file)}:${line}: ${message} (${rule})`);
  }
  count += findings.length;
}
console.log(`prose: ${files.length} pages, ${count} findings`);
process.exitCode = count ? 1 : 0;

import { SentenceSplitterSyntax, split } from "sentence-splitter";
import { StringSource } from "textlint-util-to-string";
import writeGood from "write-good";

const others = ["weasel", "illusion", "so", "thereIs", "adverb", "tooWordy", "cliches", "eprime"];
const onlyPassive = Object.fromEntries(others.map((check) => [check, false]));

/** A textlint rule: at most the share `max` of a page's sentences is passive. The finding names the lines. */
export function passiveShare({ Syntax, RuleError, report }, { max }) {
  let sentences = 0;
  const lines = [];
  return {
    [Syntax.Paragraph](node) {
      const source = new StringSource(node);
      for (const sentence of split(source.toString())) {
        if (sentence.type !== SentenceSplitterSyntax.Sentence) continue;
        ++sentences;
        const [found] = writeGood(sentence.raw, onlyPassive);
        if (!found) continue;
        const { line } = source.originalPositionFromIndex(sentence.range[0] + found.index);
        lines.push(node.loc.start.line + line - 1);
      }
    },
    [Syntax.DocumentExit](node) {
      if (lines.length <= max * sentences) return;
      const share = Math.round((100 * lines.length) / sentences);
      const message = `${share} % of ${sentences} sentences are passive, at most ${100 * max} % may be`;
      report(node, new RuleError(`${message}: lines ${lines.join(", ")}`));
    },
  };
}

// The code, strings and comments of a source text. Adjacent strings, and comment lines that follow each other,
// are one piece: a sentence may go over several of them.

const regex = /\/(?![/*])(?:[^/\\\n[]|\\.|\[(?:[^\]\\\n]|\\.)*\])+\/[a-z]*/.source;
const string = /"(?:[^"\\\n]|\\[\s\S])*"/.source, tick = /'(?:[^'\\\n]|\\[\s\S])*'/.source;
const comment = /\/\/[^\n]*|\/\*[\s\S]*?\*\//.source;

const raw = /R"([^()\\\s]{0,16})\([\s\S]*?\)\1"/.source;
const character = /(?<![0-9A-Za-z_])'(?:[^'\\\n]|\\.)+'/.source;  // 1'000 has none
const long = /"""(?:[^\\]|\\[\s\S])*?"""|'''(?:[^\\]|\\[\s\S])*?'''/.source;

const tokens = {
  cpp: new RegExp([comment, raw, string, character].join("|"), "g"),
  python: new RegExp(["#[^\\n]*", long, string, tick].join("|"), "g"),
  typescript: new RegExp([comment, string, tick, "`", "[{}]", regex].join("|"), "g"),
};

/** The language of a file, by its name or the first line of a script; none: null. */
export function languageOf(file, text = "") {
  if (/\.(cpp|hpp|h)(\.in)?$/.test(file)) return "cpp";
  if (/\.pyi?$/.test(file) || /^#!.*\bpython/.test(text)) return "python";
  return /\.(ts|mjs|js)$/.test(file) || /^#!.*\bnode/.test(text) ? "typescript" : null;
}

/** Where a template string goes on at `from`: its end, and whether code in ${} follows. */
function templateEnd(text, from) {
  for (let i = from; i < text.length; ++i) {
    if (text[i] === "\\") ++i;
    else if (text[i] === "`") return [i + 1, false];
    else if (text[i] === "$" && text[i + 1] === "{") return [i + 2, true];
  }
  return [text.length, false];
}

// After a value, a slash divides.
function divides(before) {
  const last = before.slice(-20).trimEnd();
  return /[\w)\]$"'`]$/.test(last) && !/\b(return|typeof|case)$/.test(last);
}

/** [{kind: "code" | "string" | "comment", text, at}] with the offsets of a text's pieces. */
export function rawPieces(text, language) {
  const found = [], token = tokens[language], resumes = [];
  let code = 0, depth = 0;
  const add = (kind, from, to) => {
    if (from > code) found.push({ kind: "code", text: text.slice(code, from), at: code });
    found.push({ kind, text: text.slice(from, to), at: from });
    token.lastIndex = code = to;
  };
  const template = (from, inside) => {
    const [end, more] = templateEnd(text, inside);
    if (more) resumes.push(depth);
    add("string", from, end);
  };
  token.lastIndex = 0;
  for (let m = token.exec(text); m; m = token.exec(text)) {
    const [one] = m, typescript = language === "typescript";
    if (/^(\/\/|\/\*)/.test(one) || (language === "python" && one[0] === "#")) {
      add("comment", m.index, token.lastIndex);
    } else if (typescript && one === "{") {
      ++depth;
    } else if (typescript && one === "}") {
      if (resumes.at(-1) === depth) {
        resumes.pop();
        template(m.index, token.lastIndex);
      } else {
        --depth;
      }
    } else if (typescript && one === "`") {
      template(m.index, token.lastIndex);
    } else if (typescript && one[0] === "/" && divides(text.slice(0, m.index))) {
      token.lastIndex = m.index + 1;
    } else {
      add("string", m.index, token.lastIndex);
    }
  }
  if (code < text.length) found.push({ kind: "code", text: text.slice(code), at: code });
  return found;
}

/** The same, with what belongs together joined, and a `line` for each piece. Joined text is without the marks of
 * comments and strings between its lines. */
export function pieces(text, language) {
  const joined = [];
  let line = 1;
  for (const { kind, text: own } of rawPieces(text, language)) {
    const last = joined.at(-1), before = joined.at(-2);
    if (kind !== "code" && last?.kind === "code" && before?.kind === kind && /^\s+$/.test(last.text)) {
      joined.pop();
      before.text += last.text + own;
    } else {
      joined.push({ kind, text: own, line });
    }
    line += own.split("\n").length - 1;
  }
  for (const piece of joined) {
    if (piece.kind === "comment") piece.text = piece.text.replace(/\n[ \t]*(\/\/\/?<?|\*(?!\/)|#+)/g, "\n");
    if (piece.kind === "string") piece.text = piece.text.replace(/["'`](\s*\n\s*)(u8|[frbu])?["'`]/g, "$1");
  }
  return joined;
}

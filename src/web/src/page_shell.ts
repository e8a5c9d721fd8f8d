// What the three pages have in common around their content. vite.config.ts puts it into page.html,
// study.html and map.html while it builds them, so this file runs in Node.

const headOf = (title: string): string => `<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<!-- The page may load nothing at all: what it shows travels inside it. -->
<meta http-equiv="Content-Security-Policy"
      content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<title>${title}</title>
<script>
// Before the first paint, so that a dark room stays dark.
document.documentElement.dataset.theme =
  matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
</script>
</head>`;

// A page of several subjects chooses among them, and shows the health of the present one.
const pickerOf = (picker: string): string => `
    <label id="run-picker" class="field" hidden>${picker} <select id="run-select"></select></label>
    <span id="health-badge" class="badge"></span>`;

const topOf = ({ skip, to, picker }: Record<string, string>, numbers: string): string =>
  `<a class="skip" href="${to}">${skip}</a>
<header class="top">
  <div class="brand">
    <svg class="mark" viewBox="0 0 32 32" width="34" height="34" aria-hidden="true">
      <path d="M16 3v26" class="mark-axis"/>
      <path d="M7 26c0-4 18-3 18-7S7 16 7 12 25 10 25 6" class="mark-screw"/>
    </svg>
    <div>
      <h1 id="run-name" dir="auto">Chasles</h1>
      <p id="run-line" class="muted"></p>
    </div>
  </div>
  <div class="top-controls">${picker ? pickerOf(picker) : ''}
    <button id="theme-button" type="button" title="Switch between light and dark">Dark</button>
    <button id="print-button" type="button" title="Print, or save as PDF">Print</button>
  </div>
</header>

<noscript><p class="notice">This page draws with JavaScript, which is switched off. ${numbers}</p></noscript>`;

const attributes = (text: string): Record<string, string> =>
  Object.fromEntries([...text.matchAll(/([a-z]+)="([^"]*)"/g)].map(([, name, value]) => [name, value]));

function replaced(html: string, tag: string,
  by: (given: Record<string, string>, content: string) => string): string {
  const found = new RegExp(`<${tag}([^>]*)>([^]*?)</${tag}>`).exec(html);
  if (!found) throw new Error(`a page without <${tag}>…</${tag}>`);
  const [whole, given, content] = found;
  return html.replace(whole, () => by(attributes(given), content));
}

/** Replaces `<page-head title>` by the head, and `<page-top skip to picker>` by the skip link (its
 *  text and target), the line with the name, and its content as what the page says without
 *  JavaScript. `picker`: what a page of several shows; none: a page of one. */
export function withShell(html: string): string {
  const head = replaced(html, 'page-head', ({ title }) => headOf(title));
  return replaced(head, 'page-top', topOf);
}

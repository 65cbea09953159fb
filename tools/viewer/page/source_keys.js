// What keys do to a text: Enter keeps the indentation, Tab moves lines, Ctrl+/ makes comments of them. Each takes and
// returns {text, begin, end}: a text with what is chosen of it. Nothing here touches the page.

const kIndent = 4;

const indentOf = (line) => /^[ \t]*/.exec(line)[0];
const startOf = (text, at) => text.lastIndexOf("\n", at - 1) + 1;

function put({ text, begin, end }, inserted, caret = inserted.length) {
    return { text: text.slice(0, begin) + inserted + text.slice(end), begin: begin + caret, end: begin + caret };
}

export function newline(of) {
    const { text, begin, end } = of;
    const before = text.slice(startOf(text, begin), begin);
    const indent = indentOf(before);
    const opens = before.trimEnd().endsWith("{");
    const inner = `\n${indent}${opens ? " ".repeat(kIndent) : ""}`;
    return put(of, opens && text[end] === "}" ? `${inner}\n${indent}` : inner, inner.length);
}

/** `}` stands below what it ends. */
export function closing(of) {
    const { text, begin } = of;
    const start = startOf(text, begin);
    const before = text.slice(start, begin);
    if (before.trim() || before.length < kIndent) return put(of, "}");
    return put({ ...of, begin: begin - Math.min(kIndent, before.length) }, "}");
}

/** Does something to each line that is chosen; the choice then holds them whole. */
function eachLine({ text, begin, end }, change) {
    const first = startOf(text, begin);
    // A line of which nothing is chosen does not count.
    const last = end > begin && text[end - 1] === "\n" ? end - 1 : end;
    const stop = text.indexOf("\n", last) < 0 ? text.length : text.indexOf("\n", last);
    const before = text.slice(first, stop).split("\n");
    const after = change(before);
    const made = { text: text.slice(0, first) + after.join("\n") + text.slice(stop) };
    if (begin === end) {
        const moved = Math.max(first, begin + after[0].length - before[0].length);
        return { ...made, begin: moved, end: moved };
    }
    return { ...made, begin: first, end: first + after.join("\n").length };
}

export function indent(of) {
    if (!of.text.slice(of.begin, of.end).includes("\n")) {
        const column = of.begin - startOf(of.text, of.begin);
        return put(of, " ".repeat(kIndent - column % kIndent));
    }
    return eachLine(of, (lines) => lines.map((line) => (line.trim() ? " ".repeat(kIndent) + line : line)));
}

export function outdent(of) {
    return eachLine(of, (lines) => lines.map((line) => line.replace(/^(?: {1,4}|\t)/, "")));
}

export function comment(of) {
    return eachLine(of, (lines) => {
        const full = lines.filter((line) => line.trim());
        if (full.every((line) => /^\s*\/\//.test(line))) return lines.map((line) => line.replace(/^(\s*)\/\/ ?/, "$1"));
        const column = Math.min(...full.map((line) => indentOf(line).length));
        return lines.map((line) => (line.trim() ? `${line.slice(0, column)}// ${line.slice(column)}` : line));
    });
}

/** A snippet of the protocol of language servers: `${1:name}` is what is chosen first, `$0` where the caret goes. */
export function fromSnippet(snippet, indentation = "") {
    let chosen = null;
    let text = "";
    let from = 0;
    for (const found of snippet.matchAll(/\$(?:(\d+)|\{(\d+)(?::([^}]*))?\})/g)) {
        text += snippet.slice(from, found.index).replaceAll("\n", `\n${indentation}`);
        const number = Number(found[1] ?? found[2]);
        if (chosen === null || number === 1 && chosen.number !== 1) chosen = { number, begin: text.length, end: text.length + (found[3] ?? "").length };
        text += found[3] ?? "";
        from = found.index + found[0].length;
    }
    text += snippet.slice(from).replaceAll("\n", `\n${indentation}`);
    return { text, begin: chosen?.begin ?? text.length, end: chosen?.end ?? text.length };
}

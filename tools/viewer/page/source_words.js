// What the words of a text are, for their colours: as a lexer sees them, so that typing need not wait for the compiler.
// Nothing here touches the page.

const kKeywords = new Set(["break", "case", "const", "continue", "default", "do", "else", "enum", "fablet", "false", "for", "if", "import",
    "in", "inout", "out", "return", "struct", "switch", "true", "while"]);
const kTypes = /^(?:(?:bool|int|uint|float)(?:[2-4](?:x[2-4])?)?|void|string|ImageTexture[23]D|Spline|ColorRamp|Object|Material(?:Composition)?|SurfacePoint|\w+Attributes)$/;
const kWords = /\/\/.*|\/\*.*?(?:\*\/|$)|"(?:[^"\\]|\\.)*"?|@\s*[A-Za-z_]\w*|(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)[a-zA-Z]?|[A-Za-z_]\w*/g;

function kindOf(word, before, after) {
    if (word.startsWith("/")) return "comment";
    if (word.startsWith('"')) return "string";
    if (word.startsWith("@")) return "marker";
    if (/^[\d.]/.test(word)) return "number";
    if (kKeywords.has(word)) return "keyword";
    if (kTypes.test(word)) return "type";
    if (/^\s*\(/.test(after)) return "function";
    return before.endsWith(".") ? "member" : "";
}

/** The coloured words of a line as {begin, end, kind}; `inside`: it begins in a comment. Also whether it ends in one. */
export function wordsOf(line, inside = false) {
    const words = [];
    let from = 0;
    if (inside) {
        const end = line.indexOf("*/");
        from = end < 0 ? line.length : end + 2;
        if (from > 0) words.push({ begin: 0, end: from, kind: "comment" });
        if (end < 0) return { words, inside: true };
        inside = false;
    }
    kWords.lastIndex = from;
    for (let found; (found = kWords.exec(line));) {
        const [begin, end] = [found.index, found.index + found[0].length];
        const kind = kindOf(found[0], line.slice(0, begin), line.slice(end));
        if (kind) words.push({ begin, end, kind });
        inside = found[0].startsWith("/*") && (found[0].length < 4 || !found[0].endsWith("*/"));
    }
    return { words, inside: inside && words.at(-1)?.kind === "comment" && words.at(-1).end === line.length };
}

/** For each line whether it begins in a comment. */
export function commentStarts(lines) {
    let inside = false;
    return lines.map((line) => {
        const was = inside;
        // Most lines have nothing that matters.
        if (inside || line.includes("/*")) inside = wordsOf(line, inside).inside;
        return was;
    });
}

/** The identifier that ends at a column, which is being typed. */
export function wordBefore(line, column) {
    return /[A-Za-z_]\w*$/.exec(line.slice(0, column))?.[0] ?? "";
}

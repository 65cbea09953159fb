// What programs say, in the page's own words: without options of commands, and without temporary folders, which nobody knows.
// Nothing here touches the page.

const kFolder = /(?:\/[^\s`"':/]+)*\/openfab\.tmp-\w{6}\/(?:(?:dropped|loop|page|tried|made)\/|openfab\.tmp-\w{6}\/)*/g;
const kCommand = /(?:^|[\s`(,=])--(?:[a-z][a-z]|z )|`-[a-z] |\bopenfab (?!view`)[a-z]|\bopenflc (?:build|run|check|emit|fmt|passes)\b|\bscripts\/|"repair"/;
/** What an option is called where no option is. */
const kMeans = [
    [/\b(?:and )?`--memory` allows (\S+)/g, "more than the $1 that are allowed"],
    [/ (?:of|that) `--memory`(?: allows,?)?/g, " that are allowed"],
    [/^((?:error|warning|note): )?--set (\S+): /, "$1$2: "],
    [/^((?:error|warning|note): )?`?--[a-z-]+(?: [^`:]*)?`?: /, "$1"],
    [/, the `--[a-z-]+`/g, ""],
    [/(If that is wrong, )import it with `--unit cm` \(or m, um, in\) or `--size 60mm`/g, "$1choose another at `read as`"],
];
/** Of a remedy that the page has not, nothing is left to say. */
const kElsewhere = /^(?:or )?(?:allow more|raise it|if the file is sound|if you trust the file|a longer limit)\b[^;.]*$/;
/** Where nothing else is left of a message. */
export const kNotHere = "this is not possible on the page";

/** The clauses of a line, each with the mark that ends it; what is in brackets is one of its own, and has none. */
function clausesOf(line) {
    const clauses = [""];
    let depth = 0;
    for (let i = 0; i < line.length; ++i) {
        const c = line[i];
        if (c === "(" && depth++ === 0) clauses.push("");
        clauses[clauses.length - 1] += c;
        if (c === ")" && depth > 0 && --depth === 0) clauses.push("");
        else if (depth === 0 && /[;,.]/.test(c) && /\s/.test(line[i + 1] ?? " ")) clauses.push("");
        else if (depth === 0 && /^ (?:or|and) /.test(line.slice(i + 1, i + 6))) clauses.push("");
    }
    return clauses.filter(Boolean);
}

function lineWords(line) {
    if (/^\s/.test(line)) return line.replace(kFolder, "");  // a line of a file, and the mark below it
    let text = line.replace(kFolder, "");
    for (const [from, to] of kMeans) text = text.replace(from, to);
    if (!kCommand.test(text)) return text;
    const [, head] = /^((?:[^\s:]+:\d+(?::\d+)?: )?(?:error|warning|note|help): )?/.exec(text);
    let dropped = false;
    const kept = clausesOf(text.slice(head?.length ?? 0)).filter((one) => {
        // What follows a clause that is left out, up to the next mark, is about it.
        const command = kCommand.test(one) || kElsewhere.test(one.trim().replace(/[;,.]$/, "")) || (dropped && /^ ?(?:\(|(?:and|which|as|it|then|with|that)\b)/.test(one.trimStart()));
        dropped = command && !/[;.]$/.test(one);
        return !command;
    });
    const made = kept.join("").replace(/\s+([;,.])(?=\s|$)/g, "$1").replace(/; or /g, "; ").replace(/[\s;,:]+$/, "").replace(/^(?:[\s;,]+|or |and )+/, "").replace(/ (?:or|and|with|as|use)$/, "");
    return made ? `${head ?? ""}${made}` : "";
}

/** A message as it is shown; of one that is only about commands, that there is no way on the page. */
export function pageWords(text) {
    if (!text) return text;
    const lines = text.split("\n").map((line) => (line ? lineWords(line) : line));
    const made = lines.filter((line, i) => line || !text.split("\n")[i]).join("\n");
    return made.trim() ? made : kNotHere;
}

const kKeys = new Set(["message", "notes", "trouble", "error", "difference"]);

/** For JSON.parse: what of an answer is shown as words. */
export const inPageWords = (key, value) => (typeof value === "string" && kKeys.has(key) ? pageWords(value) : value);

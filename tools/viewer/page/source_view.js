// Draws a text with its colours, line numbers and marks below a field that has the letters' shapes but not their colour: the
// browser edits, this shows. Only the lines in view are drawn, so that a text may be long.

import { element } from "./format.js";
import { commentStarts, wordsOf } from "./source_words.js";

const byId = (id) => document.getElementById(id);
const kLine = 18, kTop = 4, kLeft = 6, kTab = 4, kMargin = 20;

export class SourceView {
    constructor() {
        this.host = byId("editor");
        this.source = byId("source");
        this.lines = [""];
        this.comments = [false];
        this.diagnostics = [];
        this.worst = new Map();
        this.pen = document.createElement("canvas").getContext("2d");
        this.host.addEventListener("scroll", () => this.draw());
        new ResizeObserver(() => this.draw(true)).observe(this.host);
    }

    /** Shows a text and what is said of it: {line, column, end_line, end_column, severity, message}, from 1. */
    show(text, diagnostics) {
        this.lines = text.split("\n");
        this.comments = commentStarts(this.lines);
        this.diagnostics = diagnostics;
        this.worst = new Map();
        for (const d of diagnostics) if (this.worst.get(d.line) !== "error") this.worst.set(d.line, d.severity);
        this.fitSource();
        this.draw(true);
    }

    /** The field is as large as its text: the box around it scrolls, with all that is drawn. */
    fitSource() {
        const longest = Math.max(...this.lines.map((line) => line.length));
        this.pen.font = getComputedStyle(this.host).font;
        this.letter = this.pen.measureText("0".repeat(64)).width / 64;
        const sheet = byId("sheet");
        for (const one of [sheet, byId("lines")]) one.style.minHeight = `${this.lines.length * kLine + 2 * kTop}px`;
        sheet.style.minWidth = `${Math.ceil((longest + 2) * this.letter) + 2 * kLeft}px`;
        // Wide letters and tabs take more.
        if (this.source.scrollWidth > this.source.clientWidth) sheet.style.minWidth = `${this.source.scrollWidth}px`;
    }

    draw(anew = false) {
        const first = Math.floor(this.host.scrollTop / kLine);
        const last = Math.min(this.lines.length, Math.ceil((this.host.scrollTop + this.host.clientHeight) / kLine));
        if (!anew && this.drawn?.from <= first && last <= this.drawn.to) return;
        const [from, to] = [Math.max(0, first - kMargin), Math.min(this.lines.length, last + kMargin)];
        this.drawn = { from, to };
        const [gutter, letters] = [[], []];
        for (let i = from; i < to; ++i) {
            gutter.push(element("span", { class: this.worst.get(i + 1) ?? "" }, String(i + 1)), "\n");
            letters.push(...this.line(i), "\n");
        }
        for (const [id, parts] of [["gutter", gutter], ["marks", letters]]) {
            byId(id).replaceChildren(...parts);
            byId(id).style.top = `${from * kLine}px`;
        }
    }

    /** A line in its colours, with marks under what is wrong. */
    line(i) {
        const line = this.lines[i];
        const { words } = wordsOf(line, this.comments[i]);
        // Columns count code points.
        const points = [...line];
        const place = (column) => points.slice(0, Math.max(column - 1, 0)).join("").length;
        const marks = this.diagnostics.filter((d) => d.line === i + 1).map((d) => {
            const begin = place(d.column);
            return { begin, end: Math.max(d.end_line > d.line ? line.length : place(d.end_column), begin + 1), severity: d.severity };
        });
        const edges = [...new Set([0, line.length, ...words.flatMap((w) => [w.begin, w.end]), ...marks.flatMap((m) => [m.begin, m.end])])].sort((a, b) => a - b);
        const parts = [];
        for (let e = 0; e + 1 < edges.length; ++e) {
            const [begin, end] = [edges[e], edges[e + 1]];
            const mark = marks.find((m) => m.begin <= begin && end <= m.end);
            const kind = words.find((w) => w.begin <= begin && end <= w.end)?.kind;
            const text = line.slice(begin, end) || " ";
            const word = kind ? element("span", { class: kind }, text) : text;
            parts.push(mark ? element("mark", { class: mark.severity }, word) : word);
        }
        return parts;
    }

    widthOf(text) { return this.pen.measureText(this.spread(text)).width; }

    /** Tabs as the blanks that they take. */
    spread(text) {
        let out = "";
        for (const c of text) out += c === "\t" ? " ".repeat(kTab - out.length % kTab) : c;
        return out;
    }

    /** Line and column, from 0, of a place in the text. */
    placeOf(offset) {
        const before = this.source.value.slice(0, offset);
        const line = before.split("\n").length - 1;
        return { line, character: offset - (before.lastIndexOf("\n") + 1) };
    }

    /** Where a letter stands in the window: its left edge, top and bottom. */
    boxOf({ line, character }) {
        const box = this.source.getBoundingClientRect();
        const top = box.top + kTop + line * kLine;
        return { left: box.left + kLeft + this.widthOf(this.lines[line]?.slice(0, character) ?? ""), top, bottom: top + kLine };
    }

    /** The letter at a point of the window, or null. */
    placeAt(clientX, clientY) {
        const box = this.source.getBoundingClientRect();
        const line = Math.floor((clientY - box.top - kTop) / kLine);
        const text = this.lines[line];
        const x = clientX - box.left - kLeft;
        if (text === undefined || x < 0) return null;
        let [low, high] = [0, text.length];
        while (low < high) {
            const middle = (low + high + 1) >> 1;
            if (this.widthOf(text.slice(0, middle)) <= x) low = middle; else high = middle - 1;
        }
        return low < text.length ? { line, character: low } : null;
    }

    /** Brings a line into view, somewhat below the top. */
    reveal(line) {
        const y = line * kLine;
        if (y < this.host.scrollTop || y > this.host.scrollTop + this.host.clientHeight - 2 * kLine) this.host.scrollTop = Math.max(0, y - 5 * kLine);
        this.host.scrollLeft = 0;
    }
}

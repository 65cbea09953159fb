// The fablet's source, with its diagnostics at the line.

import { getJson, postJson, query } from "./api.js";
import { element } from "./format.js";

const byId = (id) => document.getElementById(id);
const kCheckMs = 350;

export class Editor {
    /** `run` does something that asks the server, and shows what comes of it. */
    constructor(run) {
        this.run = run;
        this.fablet = -1;
        this.fablets = [];
        this.stored = "";   // the text on disk, as last seen
        this.stamp = "";    // its hash, by which the server knows whether it is still that
        this.known = new Set();  // stamps of what was read or written here
        this.diagnostics = [];
        this.listen();
    }

    get text() { return byId("source").value; }
    get edited() { return this.text !== this.stored; }

    async show(details) {
        this.fablets = details.fablets;
        this.showFablets();
        await this.load(false);
        if (!this.edited) this.diagnostics = details.diagnostics;
        this.showDiagnostics();
    }

    showFablets() {
        const select = byId("fablet");
        const names = this.fablets.map((f) => f.file);
        if ([...select.options].map((o) => o.text).join() !== names.join())
            select.replaceChildren(...names.map((name, i) => element("option", { value: i }, name)));
        if (this.fablet < 0 || this.fablet >= names.length) this.fablet = 0;
        select.value = this.fablet;
    }

    /** Takes the text on disk; where there are changes that were not saved, only if that is wanted. */
    async load(force) {
        const entry = this.fablets[this.fablet];
        if (!entry || (entry.stamp === this.stamp && !force)) return;
        if (this.edited && !force) {
            if (!entry.stamp || this.known.has(entry.stamp)) return;
            this.known.add(entry.stamp);
            if (!confirm(`${entry.file} was changed by another program. Take its text, and lose what was not saved here?`)) {
                this.stamp = entry.stamp;  // saving replaces it
                return;
            }
        }
        const got = await getJson("api/source?" + query({ fablet: this.fablet }));
        this.stored = got.text;
        this.stamp = got.stamp;
        this.known.add(got.stamp);
        const source = byId("source");
        const at = source.selectionStart;
        source.value = got.text;
        if (!force) source.setSelectionRange(at, at);
        this.showText();
        this.onload?.();
    }

    /** Puts a text that was not typed in place of the one that is there. */
    replace(text) {
        const source = byId("source");
        if (text === source.value) return;
        const top = source.scrollTop;
        source.value = text;
        source.scrollTop = top;
        source.dispatchEvent(new Event("input"));
    }

    showText() {
        byId("save").disabled = !this.edited;
        this.showDiagnostics();
    }

    showDiagnostics() {
        const lines = this.text.split("\n");
        const here = this.diagnostics.filter((d) => d.fablet === this.fablet);
        const worst = new Map();
        for (const d of here) if (worst.get(d.line) !== "error") worst.set(d.line, d.severity);
        const gutter = byId("gutter");
        gutter.replaceChildren(...lines.flatMap((_, i) => [element("span", { class: worst.get(i + 1) ?? "" }, String(i + 1)), "\n"]));
        byId("marks").replaceChildren(...this.marked(lines, here));
        byId("diagnostics").replaceChildren(...this.diagnostics.map((d) => element("li", { class: d.severity },
            element("button", { onclick: () => this.run(() => this.goTo(d)) }, `${d.fablet === this.fablet ? "" : `${d.file}: `}line ${d.line}: ${d.message}`),
            ...d.help.map((text) => element("div", { class: "help" }, text)))));
        this.scroll();
    }

    marked(lines, diagnostics) {
        const parts = [];
        lines.forEach((line, i) => {
            const on = diagnostics.filter((d) => d.line === i + 1).sort((a, b) => a.column - b.column);
            // Columns count code points.
            const points = [...line];
            let from = 0;
            for (const d of on) {
                const begin = Math.min(Math.max(d.column - 1, from), points.length);
                const end = d.end_line > d.line ? points.length : Math.max(Math.min(d.end_column - 1, points.length), begin + 1);
                parts.push(points.slice(from, begin).join(""), element("mark", { class: d.severity, title: d.message }, points.slice(begin, end).join("") || " "));
                from = end;
            }
            parts.push(points.slice(from).join(""), "\n");
        });
        return parts;
    }

    scroll() {
        const source = byId("source");
        byId("gutter").scrollTop = byId("marks").scrollTop = source.scrollTop;
        byId("marks").scrollLeft = source.scrollLeft;
    }

    async goTo(d) {
        if (d.fablet < 0) return;  // a module, which is not edited here
        if (d.fablet !== this.fablet) await this.choose(d.fablet);
        const lines = this.text.split("\n");
        const before = lines.slice(0, d.line - 1).reduce((n, line) => n + line.length + 1, 0);
        const at = before + [...(lines[d.line - 1] ?? "")].slice(0, d.column - 1).join("").length;
        const source = byId("source");
        source.focus();
        source.setSelectionRange(at, at);
        source.scrollTop = Math.max(0, (d.line - 6) * 18);
        this.scroll();
    }

    async choose(fablet) {
        if (this.edited && !confirm("Changes to this fablet were not saved. Drop them?")) {
            byId("fablet").value = this.fablet;
            return;
        }
        this.fablet = fablet;
        byId("fablet").value = fablet;
        await this.load(true);
    }

    async check() {
        const text = this.text;
        await this.run(async () => {
            const got = await postJson("api/check", { fablet: this.fablet, text });
            if (text !== this.text) return;
            this.diagnostics = got.diagnostics;
            this.showDiagnostics();
        });
    }

    /** Saves one after the other: each says what it replaces. */
    save() {
        this.saving = (this.saving ?? Promise.resolve()).then(() => this.saveNow());
        return this.saving;
    }

    async saveNow() {
        if (!this.edited) return;
        const text = this.text;
        await this.run(async () => {
            const got = await postJson("api/source", { fablet: this.fablet, text, stamp: this.stamp });
            this.stored = text;
            this.stamp = got.stamp;
            this.known.add(got.stamp);
            if (got.notes) { byId("files_note").textContent = got.notes.trim(); byId("files_note").hidden = false; }
            byId("save").disabled = !this.edited;
        });
    }

    listen() {
        const source = byId("source");
        source.addEventListener("scroll", () => this.scroll());
        source.addEventListener("input", () => {
            this.showText();
            clearTimeout(this.checking);
            this.checking = setTimeout(() => this.check(), kCheckMs);
        });
        source.addEventListener("keydown", (event) => {
            if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "s") {
                event.preventDefault();
                this.save();
            } else if (event.key === "Tab" && !event.shiftKey && !event.ctrlKey && !this.leaving) {
                event.preventDefault();
                source.setRangeText("    ", source.selectionStart, source.selectionEnd, "end");
                source.dispatchEvent(new Event("input"));
            }
            // Escape, then Tab, leaves the field.
            this.leaving = event.key === "Escape" || (this.leaving && event.key === "Shift");
        });
        byId("save").addEventListener("click", () => this.save());
        byId("fablet").addEventListener("change", (event) => this.run(() => this.choose(Number(event.target.value))));
    }
}

// The fablet's source: what is on disk and what is typed, what the compiler says of it, and one history of both hands,
// typing and the graph.

import { getJson, postJson, query } from "./api.js";
import { element } from "./format.js";
import { Pane } from "./panes.js";
import { SourceAssist } from "./source_assist.js";
import { endOfChange, TextHistory } from "./source_history.js";
import { closing, comment, indent, newline, outdent } from "./source_keys.js";
import { SourceView } from "./source_view.js";

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
        this.history = new TextHistory();
        this.view = new SourceView();
        this.assist = new SourceAssist({
            ask: (action) => postJson("api/assist", { fablet: this.fablet, text: this.text, action }),
            view: this.view, put: (begin, end, made) => this.put(begin, end, made), diagnosticsAt: (place) => this.diagnosticsAt(place),
        });
        this.pane = new Pane("text", () => { this.showText(); byId("source").focus({ preventScroll: true }); });
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
        select.hidden = names.length < 2;
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
        // What another program wrote is a step, too: what was typed comes back by undoing it.
        if (force || !this.loaded) this.history.reset(got.text);
        else this.history.record(got.text);
        this.loaded = true;
        source.value = got.text;
        if (!force) source.setSelectionRange(at, at);
        this.showText();
        this.onload?.();
    }

    /** Puts a text that was not typed in place of the one that is there. */
    replace(text) {
        const source = byId("source");
        if (text === source.value) return;
        this.history.record(text);
        this.set(text);
    }

    set(text, begin = null, end = begin) {
        const source = byId("source");
        const at = begin ?? endOfChange(source.value, text);
        source.value = text;
        source.setSelectionRange(at, begin === null ? at : end);
        source.dispatchEvent(new Event("input"));
    }

    /** What a key or a completion makes of the text; {text, begin, end}. */
    edit({ text, begin, end }) {
        this.history.record(text, performance.now());
        this.set(text, begin, end);
        this.view.reveal(this.view.placeOf(begin).line);
    }

    put(begin, end, made) {
        const text = this.text;
        this.edit({ text: text.slice(0, begin) + made.text + text.slice(end), begin: begin + made.begin, end: begin + made.end });
    }

    undo() { return this.step(this.history.undo()); }
    redo() { return this.step(this.history.redo()); }

    step(text) {
        if (text === null) return false;
        this.set(text);
        this.onstep?.();
        this.view.reveal(this.view.placeOf(byId("source").selectionStart).line);
        return true;
    }

    async format() {
        const edits = await postJson("api/assist", { fablet: this.fablet, text: this.text, action: { ask: "format" } });
        const lines = this.text.split("\n");
        const offset = ({ line, character }) => lines.slice(0, line).reduce((sum, one) => sum + one.length + 1, 0) + character;
        for (const { range, newText } of edits)
            this.replace(this.text.slice(0, offset(range.start)) + newText + this.text.slice(offset(range.end)));
    }

    showText() {
        byId("save").disabled = !this.edited;
        this.showDiagnostics();
    }

    get diagnosticsHere() { return this.diagnostics.filter((d) => d.fablet === this.fablet); }

    /** Those that cover a line and column from 0. */
    diagnosticsAt({ line, character }) {
        const column = [...this.view.lines[line].slice(0, character)].length + 1;
        return this.diagnosticsHere.filter((d) => d.line === line + 1 && d.column <= column && (d.end_line > d.line || column <= d.end_column));
    }

    showDiagnostics() {
        this.view.show(this.text, this.diagnosticsHere);
        byId("diagnostics").replaceChildren(...this.diagnostics.map((d) => element("li", { class: d.severity },
            element("button", { onclick: () => this.run(() => this.goTo(d)) }, `${d.fablet === this.fablet ? "" : `${d.file}: `}line ${d.line}: ${d.message}`),
            ...d.help.map((text) => element("div", { class: "help" }, text)))));
    }

    async goTo(d) {
        if (d.fablet < 0) return;  // a module, which is not edited here
        if (d.fablet !== this.fablet) await this.choose(d.fablet);
        const lines = this.text.split("\n");
        const before = lines.slice(0, d.line - 1).reduce((n, line) => n + line.length + 1, 0);
        const at = before + [...(lines[d.line - 1] ?? "")].slice(0, d.column - 1).join("").length;
        this.pane.show(true);
        const source = byId("source");
        source.focus({ preventScroll: true });
        source.setSelectionRange(at, at);
        this.view.reveal(d.line - 1);
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

    /** Undo and redo, of the graph's edits as well; keys that edit lines. */
    key(event) {
        const source = byId("source");
        const mod = event.ctrlKey || event.metaKey;
        const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
        const of = { text: source.value, begin: source.selectionStart, end: source.selectionEnd };
        if (this.assist.key(event)) return true;
        if (mod && key === "s") this.save();
        else if (mod && key === "z") (event.shiftKey ? this.redo() : this.undo());
        else if (mod && key === "y") this.redo();
        else if (mod && key === "/") this.edit(comment(of));
        else if (event.altKey && event.shiftKey && key === "f") this.run(() => this.format());
        else if (mod || event.altKey || event.isComposing) return false;
        else if (key === "Tab" && !this.leaving) this.edit(event.shiftKey ? outdent(of) : indent(of));
        else if (key === "Enter") this.edit(newline(of));
        else if (key === "}") this.edit(closing(of));
        else return false;
        return true;
    }

    listen() {
        const source = byId("source");
        source.addEventListener("input", (event) => {
            this.history.record(source.value, performance.now());
            this.showText();
            clearTimeout(this.checking);
            this.checking = setTimeout(() => this.check(), kCheckMs);
            if (event.inputType) this.assist.typed(event.inputType === "insertText" ? event.data?.at(-1) ?? "" : "");
        });
        source.addEventListener("beforeinput", (event) => {
            if (event.inputType !== "historyUndo" && event.inputType !== "historyRedo") return;
            event.preventDefault();
            if (event.inputType === "historyUndo") this.undo(); else this.redo();
        });
        source.addEventListener("keydown", (event) => {
            if (this.key(event)) event.preventDefault();
            // Escape, then Tab, leaves the field.
            this.leaving = event.key === "Escape" || (this.leaving && event.key === "Shift");
        });
        byId("save").addEventListener("click", () => this.save());
        byId("fablet").addEventListener("change", (event) => this.run(() => this.choose(Number(event.target.value))));
        addEventListener("beforeunload", (event) => { if (this.edited) event.preventDefault(); });
    }
}

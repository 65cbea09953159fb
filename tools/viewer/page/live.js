// The live loop on a world: uniforms as controls, the fablet in an editor with its diagnostics at the line.

import { getJson, postJson, query } from "./api.js";
import { element } from "./format.js";

const byId = (id) => document.getElementById(id);
const kCheckMs = 350;
const kSetMs = 120;

function isColor(uniform) {
    if (uniform.kind !== "value" || uniform.type !== "float3" || uniform.array_length > 1) return false;
    return Object.entries(uniform.annotations).some(([name, text]) => /colou?r/i.test(name) || /colou?r/i.test(text));
}

function hexOf(values) {
    return "#" + values.map((v) => Math.round(255 * Math.min(Math.max(v, 0), 1)).toString(16).padStart(2, "0")).join("");
}

function numbersOf(hex) {
    return [1, 3, 5].map((i) => Number((parseInt(hex.slice(i, i + 2), 16) / 255).toFixed(4)));
}

export class LivePanel {
    constructor(model, fail) {
        this.model = model;
        this.fail = fail;
        this.version = -1;
        this.fablet = -1;
        this.stored = "";   // the text on disk, as last seen
        this.stamp = "";    // its hash, by which the server knows whether it is still that
        this.diagnostics = [];
        this.listen();
    }

    get text() { return byId("source").value; }
    get edited() { return this.text !== this.stored; }

    async showState(live) {
        if (!live?.watch) return;
        byId("write").disabled = !live.writable;
        byId("write").title = live.phase === "failed" ? "The print with these values failed" : "Write the changed uniforms to the world's file";
        if (live.version === this.version) return;
        this.version = live.version;
        try {
            this.details = await getJson("api/live");
        } catch (error) {
            this.version = -1;
            return this.fail(error);
        }
        this.showDraft(live.draft);
        this.showUniforms();
        this.showFablets();
        await this.loadSource(false);
        if (!this.edited) this.diagnostics = this.details.diagnostics;
        this.showDiagnostics();
    }

    showDraft(draft) {
        const select = byId("draft");
        const choices = [...new Set([1, 2, 3, 4, 6, 8, 12, 16, draft])].sort((a, b) => a - b);
        select.replaceChildren(...choices.map((n) => element("option", { value: n, selected: n === draft }, `${n} ×`)));
    }

    // Uniforms.

    showUniforms() {
        const list = byId("uniforms");
        byId("revert").disabled = this.details.changed === 0;
        // Not under a hand that holds a slider.
        if (list.contains(document.activeElement) && list.dataset.shape === this.shape()) return this.markChanged();
        list.dataset.shape = this.shape();
        list.replaceChildren(...this.details.objects.map((object) => element("fieldset", {},
            element("legend", {}, object.name),
            ...object.uniforms.filter((u) => u.kind !== "object").map((u) => this.control(object, u)))));
        this.markChanged();
    }

    shape() { return JSON.stringify(this.details.objects.map((o) => [o.name, o.uniforms.map((u) => [u.name, u.type, u.annotations])])); }

    markChanged() {
        for (const object of this.details.objects)
            for (const uniform of object.uniforms)
                byId(`u_${object.name}_${uniform.name}`)?.classList.toggle("changed", uniform.changed);
    }

    control(object, uniform) {
        const set = (value) => this.set(object.name, uniform.name, value);
        const label = uniform.annotations.label ?? uniform.name;
        const row = element("div", { class: "uniform", id: `u_${object.name}_${uniform.name}` },
            element("span", { class: "name", title: [`${uniform.type} ${uniform.name}`, uniform.annotations.help].filter(Boolean).join(": ") }, label));
        const value = uniform.value ?? uniform.default;
        if (uniform.array_length > 1) return this.numberRow(row, uniform, value, set, label);
        if (uniform.kind === "material" || uniform.kind === "texture2d" || uniform.kind === "texture3d") {
            const names = uniform.kind === "material" ? this.details.materials : this.details.textures;
            row.append(element("select", { "aria-label": label, onchange: (e) => set(e.target.value) },
                ...names.map((name) => element("option", { selected: name === value?.[0] }, name))));
        } else if (uniform.type === "bool") {
            row.append(element("input", { type: "checkbox", "aria-label": label, checked: Boolean(value?.[0]), onchange: (e) => set(e.target.checked) }));
        } else if (isColor(uniform)) {
            row.append(element("input", { type: "color", "aria-label": label, value: hexOf(value ?? [0, 0, 0]), oninput: (e) => set(numbersOf(e.target.value)) }));
        } else if (uniform.components === 1) {
            this.slider(row, uniform, value?.[0] ?? 0, set, label);
        } else {
            return this.numberRow(row, uniform, value, set, label);
        }
        return row;
    }

    slider(row, uniform, value, set, label) {
        const given = (name) => (uniform.annotations[name] === undefined ? null : Number(uniform.annotations[name]));
        // Without limits: twice the value, and below 0 where the value is.
        const low = given("min") ?? Math.min(0, -2 * Math.abs(value) * (value < 0));
        const high = given("max") ?? (value === 0 ? low + 1 : Math.max(low + Math.abs(value), 2 * Math.abs(value)));
        const step = given("step") ?? (uniform.type === "int" || uniform.type === "uint" ? 1 : Number(((high - low) / 200).toPrecision(1)));
        const range = element("input", { type: "range", min: low, max: high, step, "aria-label": label });
        const number = element("input", { type: "number", min: given("min"), max: given("max"), step: "any", "aria-label": `${label}, number` });
        range.value = number.value = value;
        range.addEventListener("input", () => { number.value = range.value; set(Number(range.value)); });
        number.addEventListener("change", () => { range.value = number.value; if (number.value !== "") set(Number(number.value)); });
        row.append(range, number);
    }

    numberRow(row, uniform, value, set, label) {
        if (uniform.kind !== "value" || uniform.type === "bool" || !value) {
            row.append(element("span", {}, "set in the world"));
            return row;
        }
        const fields = value.map((v, i) => element("input", {
            type: "number", step: "any", value: v, "aria-label": `${label} ${i}`, min: uniform.annotations.min, max: uniform.annotations.max,
            onchange: () => { if (fields.every((f) => f.value !== "")) set(fields.map((f) => Number(f.value))); },
        }));
        row.append(element("span", { class: "many" }, ...fields));
        return row;
    }

    /** The last value of a moment is sent, not each on the way. */
    set(object, uniform, value) {
        this.wanted ??= new Map();
        this.wanted.set(`${object}\0${uniform}`, { object, uniform, value });
        clearTimeout(this.setting);
        this.setting = setTimeout(async () => {
            const wanted = [...this.wanted.values()];
            this.wanted = null;
            await this.run(async () => { for (const one of wanted) await postJson("api/set", one); });
        }, kSetMs);
    }

    async run(action) {
        try {
            await action();
            this.refresh();
        } catch (error) {
            this.fail(error);
        }
    }

    // The fablet.

    showFablets() {
        const select = byId("fablet");
        const names = this.details.fablets.map((f) => f.file);
        if ([...select.options].map((o) => o.text).join() !== names.join())
            select.replaceChildren(...names.map((name, i) => element("option", { value: i }, name)));
        if (this.fablet < 0 || this.fablet >= names.length) this.fablet = 0;
        select.value = this.fablet;
    }

    /** Takes the text on disk, unless there are changes that were not saved. */
    async loadSource(force) {
        const entry = this.details.fablets[this.fablet];
        if (!entry || (entry.stamp === this.stamp && !force) || (this.edited && !force)) return;
        const got = await getJson("api/source?" + query({ fablet: this.fablet }));
        this.stored = got.text;
        this.stamp = got.stamp;
        const source = byId("source");
        const at = source.selectionStart;
        source.value = got.text;
        if (!force) source.setSelectionRange(at, at);
        this.showText();
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
            element("button", { onclick: () => this.goTo(d) }, `${d.fablet === this.fablet ? "" : `${d.file}: `}line ${d.line}: ${d.message}`),
            ...d.help.map((text) => element("div", { class: "help" }, text)))),
            ...(this.details?.message ? [element("li", {}, element("pre", {}, this.details.message))] : []));
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
        await this.loadSource(true);
    }

    async check() {
        const text = this.text;
        try {
            const got = await postJson("api/check", { fablet: this.fablet, text });
            if (text !== this.text) return;
            this.diagnostics = got.diagnostics;
            this.showDiagnostics();
        } catch (error) {
            this.fail(error);
        }
    }

    async save() {
        if (!this.edited) return;
        const text = this.text;
        await this.run(async () => {
            const got = await postJson("api/source", { fablet: this.fablet, text, stamp: this.stamp });
            this.stored = text;
            this.stamp = got.stamp;
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
        byId("fablet").addEventListener("change", (event) => this.choose(Number(event.target.value)).catch(this.fail));
        byId("draft").addEventListener("change", (event) => this.run(() => postJson("api/draft", { draft: Number(event.target.value) })));
        byId("write").addEventListener("click", () => this.run(() => postJson("api/write", {})));
        byId("revert").addEventListener("click", () => { byId("uniforms").dataset.shape = ""; this.run(() => postJson("api/revert", {})); });
    }
}

// What is chosen in the graph, with a control for each of its inputs.

import { element } from "./format.js";
import { titleOf } from "./graph_draw.js";
import { membersOf, short } from "./graph_look.js";
import { mayTake } from "./graph_palette.js";

const byId = (id) => document.getElementById(id);
const number = /^-?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?[fu]?$/;

/** The numbers of `float3(0.2, 0.5, 1)`, or null. */
function componentsOf(text) {
    const inside = /^float3\((.*)\)$/.exec(text)?.[1].split(",").map((one) => one.trim());
    return inside?.length === 3 && inside.every((one) => number.test(one)) ? inside.map(Number) : null;
}

// The page's colours are sRGB, OpenFL's are linear.
const toSrgb = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const toLinear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const hexOf = (color) => `#${color.map((v) => Math.round(255 * toSrgb(Math.min(Math.max(v, 0), 1))).toString(16).padStart(2, "0")).join("")}`;
const colorOf = (hex) => [1, 3, 5].map((at) => Number(toLinear(parseInt(hex.slice(at, at + 2), 16) / 255).toFixed(4)));

export class GraphInspector {
    /** `act` does an action, `drag` begins to drag a number, `goTo` shows a place of the text, `choose` chooses an input. */
    constructor({ act, drag, goTo, choose }) {
        Object.assign(this, { act, drag, goTo, choose });
    }

    show(graph, tabIndex, selected, port) {
        this.graph = graph;
        this.tabIndex = tabIndex;
        const tab = graph?.tabs[tabIndex];
        const host = byId("inspector");
        const focused = host.contains(document.activeElement) ? document.activeElement.dataset.control : null;
        host.replaceChildren();
        if (!tab) return;
        if (selected.size !== 1) {
            host.append(element("p", { class: "hint" }, selected.size ? `${selected.size} nodes are chosen: G makes a function of them, F a frame around them, C collapses them.` : "Choose a node to see what goes into it. A, or a double click, adds one."));
            if (selected.size === 0) host.append(...this.uniforms(tab));
            return;
        }
        const node = tab.nodes[[...selected][0]];
        if (!node) return;
        host.append(...this.head(node, tab));
        node.ports.forEach((one, i) => host.append(this.port(tab, node, one, i, port?.port === i)));
        if (this.valuesOf) this.showValues(this.valuesOf);
        if (focused) host.querySelector(`[data-control="${focused}"]`)?.focus();
    }

    /** Says what the node and its inputs are in the voxel that was picked. */
    showValues(valuesOf) {
        this.valuesOf = valuesOf;
        const tab = this.graph?.tabs[this.tabIndex];
        for (const place of byId("inspector").querySelectorAll("[data-value-of]")) {
            const node = tab?.nodes[place.dataset.valueOf];
            const values = node && valuesOf(node);
            place.textContent = values ? `in the voxel: ${membersOf(values, place.dataset.suffix).map(short).join(", ")}` : "";
        }
    }

    valuePlace(id, suffix = "") {
        return element("p", { class: "type here", "data-value-of": id, "data-suffix": suffix });
    }

    head(node, tab) {
        const parts = [element("h3", {}, titleOf(node))];
        if (node.outputs[0]?.type) parts.push(element("p", { class: "type" }, node.outputs[0].type));
        parts.push(this.valuePlace(node.id));
        if (node.module) parts.push(element("p", { class: "type" }, `from ${node.module}`));
        for (const trouble of node.troubles ?? []) parts.push(element("p", { class: "trouble" }, trouble.message));
        if (node.help) parts.push(element("p", { class: "help" }, node.help.replace(/```openfl\n?|```\n?/g, "").trim()));
        if (node.kind === "opaque") parts.push(element("pre", {}, node.text));
        const uniform = this.graph.uniforms.findIndex((u) => node.role === "uniform" && u.name === node.title && u.fablet === tab.fablet);
        if (uniform >= 0) parts.push(this.uniform(uniform));
        const nameable = uniform >= 0 || (node.kind !== "input" && node.kind !== "result" && node.outputs.length > 0 && node.kind !== "write" && node.kind !== "opaque");
        if (nameable) {
            const name = element("input", { type: "text", "aria-label": "Name", "data-control": "name", value: uniform >= 0 ? node.title : node.outputs[0].name, placeholder: "no name", onchange: () => this.act({ do: "name", node: node.id, text: name.value }) });
            parts.push(element("label", { class: "field" }, "name", name));
        }
        const buttons = [element("button", { onclick: () => this.goTo(node), title: "Show it in the text (T)" }, "Text")];
        if (node.kind !== "result" && node.kind !== "input") buttons.push(element("button", { onclick: () => this.act({ do: "delete", node: node.id }), title: "Delete (Delete)" }, "Delete"));
        parts.push(element("div", { class: "row" }, ...buttons));
        return parts;
    }

    uniform(index) {
        const uniform = this.graph.uniforms[index];
        const row = element("div", { class: "port_row" }, element("span", { class: "port_label" }, "default"));
        const { min, max } = uniform.annotations;
        row.append(...this.value(uniform.default, (text) => this.act({ do: "default", uniform: index, text }), "default", { min, max }));
        return row;
    }

    uniforms(tab) {
        const own = this.graph.uniforms.map((u, i) => [u, i]).filter(([u]) => u.fablet === tab.fablet);
        if (!tab.fablet) return [];
        const fablet = [...new Set(this.graph.tabs.map((t) => t.fablet).filter(Boolean))].indexOf(tab.fablet);
        const type = element("select", { "aria-label": "Type of a new uniform" }, ...["float", "float3", "int", "bool", "Material", "ImageTexture2D", "ImageTexture3D", "Spline", "ColorRamp"].map((one) => element("option", {}, one)));
        return [element("h3", {}, "Uniforms"), ...own.map(([u, i]) => element("div", { class: "row" }, element("span", { class: "grow" }, `${u.type} ${u.name}`),
            u.uses ? element("span", { class: "type" }, `${u.uses} ×`) : element("button", { onclick: () => this.act({ do: "delete_uniform", uniform: i }) }, "Delete"))),
        element("div", { class: "row" }, type, element("button", { onclick: () => this.act({ do: "add_uniform", fablet, type: type.value, text: type.value === "Material" ? "material" : "value" }) }, "Add"))];
    }

    port(tab, node, port, i, isChosen) {
        const row = element("div", { class: `port_row ${isChosen ? "chosen" : ""}`, onfocusin: () => this.choose(i) },
            element("span", { class: "port_label", title: port.wants || port.type }, port.label));
        const from = port.from === undefined ? null : tab.nodes[port.from];
        if (port.begin === undefined) {
            row.append(element("span", { class: "type" }, from ? titleOf(from) : ""));
            return row;
        }
        const set = (text) => this.act({ do: "set", node: node.id, port: i, text });
        row.append(...this.value(port.text, set, `port${i}`, port.plain ? { expose: { do: "expose", node: node.id, port: i } } : {}));
        const type = port.wants || port.type;
        const select = element("select", { "aria-label": `Wire to ${port.label}`, "data-control": `wire${i}`, onchange: () => this.rewire(tab, node, i, select.value) }, element("option", { value: "" }, from ? `⟵ ${titleOf(from)}${port.suffix}` : "no wire"));
        if (from) select.append(element("option", { value: "none" }, "disconnect"));
        tab.nodes.forEach((one) => one.outputs.forEach((output, o) => {
            if (one.id !== node.id && mayTake(type, output.type)) select.append(element("option", { value: `n${one.id}.${o}` }, `${titleOf(one)}${o ? `.${output.name}` : ""}`));
        }));
        const shown = new Set(tab.nodes.map((one) => one.title));
        for (const input of tab.inputs) if (!shown.has(input.name) && mayTake(type, input.type)) select.append(element("option", { value: `t${input.name}` }, input.name));
        for (const u of this.graph.uniforms) if (u.fablet === tab.fablet && !shown.has(u.name) && mayTake(type, u.type)) select.append(element("option", { value: `t${u.name}` }, u.name));
        row.append(select);
        if (from && port.output === 0) row.append(this.valuePlace(from.id, port.suffix));
        if (port.plain && tab.fablet) row.append(element("button", { class: "quiet", title: "Make a uniform of this value", onclick: () => this.act({ do: "expose", node: node.id, port: i }) }, "uniform"));
        return row;
    }

    rewire(tab, node, port, value) {
        if (value === "none") this.act({ do: "disconnect", node: node.id, port });
        else if (value.startsWith("t")) this.act({ do: "set", node: node.id, port, text: value.slice(1) });
        else if (value) {
            const [from, output] = value.slice(1).split(".").map(Number);
            this.act({ do: "connect", from, output, node: node.id, port });
        }
    }

    /** Controls for a value as it is written: a slider beside a number, a colour beside three. */
    value(text, set, control, { min, max, expose }) {
        const field = element("input", { type: "text", class: "value", value: text, "aria-label": "Value", "data-control": control, spellcheck: "false", onchange: () => { if (field.value !== text) set(field.value); } });
        const made = [field];
        if (number.test(text)) {
            const now = parseFloat(text);
            const [low, high] = [Number(min ?? Math.min(0, 2 * now)), Number(max ?? (now === 0 ? 1 : Math.max(2 * now, 0)))];
            let held = null;
            const rounded = () => Number(Number(slider.value).toPrecision(4));
            // The text has the value, or the preview goes back to what the text says.
            const letGo = (done) => { held?.end(done); held = null; };
            const whole = /^-?\d+u?$/.test(text) && high - low > 4;
            const slider = element("input", { type: "range", min: low, max: high, step: whole ? 1 : (high - low) / 200, value: now, "aria-label": "Slider", "data-control": `slide_${control}`,
                onpointerdown: () => { held = expose ? this.drag(expose) : null; },
                oninput: () => { field.value = rounded(); held?.put(rounded()); },
                onchange: () => letGo(set(`${rounded()}${text.endsWith("u") ? "u" : ""}`)),
                onpointerup: () => setTimeout(() => letGo(false)), onpointercancel: () => letGo(false) });
            if (high > low) made.push(slider);
        }
        const color = componentsOf(text);
        if (color?.every((v) => v >= 0 && v <= 1)) {
            const picker = element("input", { type: "color", value: hexOf(color), "aria-label": "Colour", onchange: () => set(`float3(${colorOf(picker.value).join(", ")})`) });
            made.push(picker);
        }
        if (text === "true" || text === "false")
            made.push(element("input", { type: "checkbox", checked: text === "true", "aria-label": "Truth", onchange: (event) => set(String(event.target.checked)) }));
        return made;
    }
}

// Draws a graph as SVG, moves and scales the drawing, and says what is at a point of it.

import { heightOf, kSize, layout, rowsEnd } from "./graph_layout.js";
import { curvePaths, membersOf, short } from "./graph_look.js";

const kSvg = "http://www.w3.org/2000/svg";
const kSettleMs = 200, kLeast = 0.12, kFar = 0.4, kReadable = 0.62;

function svg(name, attributes = {}, ...children) {
    const made = document.createElementNS(kSvg, name);
    for (const [key, value] of Object.entries(attributes)) if (value !== undefined && value !== false) made.setAttribute(key, value);
    made.append(...children);
    return made;
}

const clip = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

/** What a node is called: the variable it holds, and what computes it. */
export function titleOf(node) {
    const name = node.outputs[0]?.name;
    if (node.kind === "write" && name && node.title.startsWith(".")) return name + node.title;
    if (node.kind === "input" || !name || node.kind === "write" || node.kind === "opaque") return node.title;
    return node.kind === "value" ? name : `${name} = ${node.title}`;
}

/** The kind of a type, for its colour. */
export function familyOf(type) {
    if (/^(float|int|uint|bool)$/.test(type)) return type === "bool" ? "truth" : "number";
    if (/^(float|int|uint|bool)\d/.test(type)) return "vector";
    if (/^Material/.test(type)) return type === "Material" ? "material" : "mixture";
    return "other";
}

export class GraphDrawing {
    constructor(root) {
        this.root = root;
        this.world = svg("svg");
        this.wires = svg("g", { class: "wires" });
        this.nodes = svg("g", { class: "nodes" });
        this.loose = svg("path", { class: "loose" });
        this.world.append(this.wires, this.nodes, this.loose);
        root.append(this.world);
        this.view = { x: 20, y: 20, scale: 1 };
        this.tab = null;
    }

    /** Shows a tab; `marked` are nodes with troubles by line, of a text that could not be drawn. */
    show(tab, selected, port, marked = new Map()) {
        this.tab = tab;
        this.placed = layout(tab.nodes);
        this.world.setAttribute("width", Math.max(this.placed.width, 1));
        this.world.setAttribute("height", Math.max(this.placed.height, 1));
        // A click gives the focus to a node, which is drawn anew: keys go on to the graph.
        const focused = this.nodes.contains(document.activeElement);
        this.nodes.replaceChildren(...tab.nodes.map((node) => this.node(node, marked.get(node.id))));
        if (focused) this.root.focus({ preventScroll: true });
        this.wires.replaceChildren(...tab.nodes.flatMap((node) => node.ports.map((one, i) => this.wire(node, one, i)).filter(Boolean)));
        this.select(selected, port);
    }

    /** Shows what nodes are: `lookOf` gives a node's {picture, values}. */
    showLooks(lookOf) {
        if (!this.tab) return;
        for (const made of this.nodes.children) {
            const node = this.tab.nodes[made.dataset.node];
            made.querySelector(".look")?.remove();
            if (node.look) made.append(this.look(node, lookOf(node)));
        }
        for (const wire of this.wires.children) {
            const port = this.tab.nodes[wire.dataset.node].ports[wire.dataset.port];
            const { values } = lookOf(this.tab.nodes[port.from]);
            wire.querySelector("title")?.remove();
            if (values && port.output === 0) wire.append(svg("title", {}, `${port.label}: ${membersOf(values, port.suffix).map(short).join(", ")} in the voxel`));
        }
    }

    look(node, { picture, values }) {
        const y = rowsEnd(node) + 4, side = kSize.look - 8;
        if (picture?.curve) return this.curve(node, picture, values);
        const made = svg("g", { class: "look" }, svg("rect", { class: "paper", x: 8, y, width: side, height: side, rx: 2 }));
        const lines = [];
        if (picture) {
            made.append(svg("image", { x: 8, y, width: side, height: side, href: picture.url, preserveAspectRatio: "xMidYMid" }));
            if (picture.name) lines.push(picture.name);
            else if (picture.low === undefined) lines.push("no number");
            else if (picture.type !== "MaterialComposition") lines.push(...(picture.low === picture.high ? [short(picture.low)] : [`${short(picture.low)} …`, short(picture.high)]));
        }
        if (values) lines.push(`▸ ${values.map(short).join(" ")}`);
        lines.forEach((line, i) => made.append(svg("text", { class: i === lines.length - 1 && values ? "value here" : "value", x: side + 14, y: y + 12 + 14 * i }, clip(line, 15))));
        return made;
    }

    /** Values along a line, the least at the bottom. */
    curve(node, { curve, low, high, type }, values) {
        const y = rowsEnd(node) + 4, width = kSize.width - 16, height = kSize.look - 8;
        const made = svg("g", { class: "look" }, svg("rect", { class: "paper", x: 8, y, width, height, rx: 2 }));
        curvePaths(curve, width, height - 4).forEach((d, i) => {
            const line = svg("path", { class: "curve", d, transform: `translate(8 ${y + 2})` });
            line.style.stroke = curve.colors[i % curve.colors.length];  // an attribute would be refused, as all style in markup is
            made.append(line);
        });
        const range = low === undefined ? "no number" : type === "MaterialComposition" ? "" : low === high ? short(low) : `${short(low)} … ${short(high)}`;
        made.append(svg("text", { class: "value", x: 12, y: y + 11 }, clip(range, 22)));
        if (values) made.append(svg("text", { class: "value here", x: 12, y: y + height - 4 }, clip(`▸ ${values.map(short).join(" ")}`, 22)));
        made.append(svg("title", {}, `along ${"xyz"[curve.axis]} from ${short(curve.from_mm)} mm, every ${short(curve.step_mm)} mm`));
        return made;
    }

    select(selected, port) {
        for (const one of this.nodes.children) {
            const is = selected.has(Number(one.dataset.node));
            one.classList.toggle("selected", is);
            one.setAttribute("aria-pressed", is);
            for (const row of one.querySelectorAll("[data-port]"))
                row.classList.toggle("selected", port !== null && Number(one.dataset.node) === port?.node && Number(row.dataset.port) === port.port);
        }
        for (const wire of this.wires.children)
            wire.classList.toggle("selected", port !== null && Number(wire.dataset.node) === port?.node && Number(wire.dataset.port) === port.port);
    }

    portAt(node, i) {
        const { x, y } = this.placed.at[node.id];
        return { x, y: y + kSize.head + (i + 0.5) * kSize.row };
    }

    outputAt(node, i) {
        const { x, y } = this.placed.at[node.id];
        return { x: x + kSize.width, y: i === 0 ? y + kSize.head / 2 : y + kSize.head + (i - 0.5) * kSize.row };
    }

    static path(from, to) {
        const bend = Math.max(30, Math.abs(to.x - from.x) / 2);
        return `M${from.x} ${from.y} C${from.x + bend} ${from.y} ${to.x - bend} ${to.y} ${to.x} ${to.y}`;
    }

    wire(node, port, i) {
        if (port.from === undefined) return null;
        const from = this.tab.nodes[port.from];
        const d = GraphDrawing.path(this.outputAt(from, port.output), this.portAt(node, i));
        const type = from.outputs[port.output]?.type ?? "";
        // A wide one below is easier to hit.
        return svg("g", { class: `wire ${familyOf(type)}`, "data-node": node.id, "data-port": i },
            svg("path", { class: "hit", d }), svg("path", { d }));
    }

    node(node, trouble) {
        const { x, y } = this.placed.at[node.id];
        const height = heightOf(node);
        const wrong = trouble ?? node.troubles?.find((t) => t.severity === "error")?.message;
        const warning = node.troubles?.[0]?.message;
        const made = svg("g", {
            class: `node ${node.kind} ${node.role ?? ""} ${wrong ? "wrong" : warning ? "warned" : ""}`, "data-node": node.id, transform: `translate(${x} ${y})`,
            tabindex: -1, role: "button", "aria-label": `${titleOf(node)}${wrong ? `, ${wrong}` : ""}`,
        });
        made.append(
            svg("rect", { class: "box", width: kSize.width, height, rx: 5 }),
            svg("path", { class: "head", d: `M0 ${kSize.head} V5 A5 5 0 0 1 5 0 H${kSize.width - 5} A5 5 0 0 1 ${kSize.width} 5 V${kSize.head} Z` }),
            svg("text", { class: "title", x: 10, y: 16 }, clip(titleOf(node), 22)));
        if (wrong || warning || node.help || node.kind === "opaque") made.append(svg("title", {}, wrong ?? warning ?? (node.kind === "opaque" ? node.text : node.help)));
        node.ports.forEach((port, i) => made.append(this.port(port, i)));
        node.outputs.forEach((output, i) => {
            const at = this.outputAt(node, i);
            made.append(svg("circle", { class: `out ${familyOf(output.type)}`, "data-output": i, cx: at.x - x, cy: at.y - y, r: 5 }));
            if (i > 0) made.append(svg("text", { class: "value", x: kSize.width - 10, y: at.y - y + 4, "text-anchor": "end" }, clip(output.name, 14)));
        });
        if (node.kind === "opaque" && !node.ports.length) made.append(svg("text", { class: "value", x: 10, y: kSize.head + 14 }, "…"));
        return made;
    }

    port(port, i) {
        const y = kSize.head + i * kSize.row;
        const row = svg("g", { class: "port", "data-port": i }, svg("rect", { class: "strip", x: 1, y, width: kSize.width - 2, height: kSize.row }));
        row.append(svg("circle", { class: `in ${familyOf(port.type || port.wants)} ${port.from === undefined ? "free" : ""}`, cx: 0, cy: y + kSize.row / 2, r: 4.5 }));
        row.append(svg("text", { class: "label", x: 10, y: y + 14 }, clip(port.label, 10)));
        const value = port.from === undefined ? port.text : port.suffix;
        if (value) row.append(svg("text", { class: "value", x: kSize.width - 10, y: y + 14, "text-anchor": "end" }, clip(value, 13)));
        return row;
    }

    /** What is at a point of the screen: a node, and an input or output of it, or a wire by the input it ends at. */
    at(clientX, clientY) {
        const hit = document.elementFromPoint(clientX, clientY);
        if (!hit || !this.root.contains(hit)) return null;
        const holder = hit.closest("[data-node]");
        if (!holder) return {};
        const found = { node: Number(holder.dataset.node), wire: holder.classList.contains("wire") };
        const port = found.wire ? holder : hit.closest("[data-port]");
        if (port) found.port = Number(port.dataset.port);
        if (hit.dataset.output !== undefined) found.output = Number(hit.dataset.output);
        found.dot = hit.classList.contains("in");
        return found;
    }

    toWorld(clientX, clientY) {
        const box = this.root.getBoundingClientRect();
        return { x: (clientX - box.left - this.view.x) / this.view.scale, y: (clientY - box.top - this.view.y) / this.view.scale };
    }

    /** A wire in the hand; nothing hides it. */
    drag(from, to) {
        this.loose.setAttribute("d", from ? GraphDrawing.path(from, to) : "");
    }

    move(dx, dy) {
        this.view.x += dx;
        this.view.y += dy;
        this.apply();
    }

    zoom(factor, clientX, clientY) {
        const box = this.root.getBoundingClientRect();
        const [cx, cy] = [(clientX ?? box.left + box.width / 2) - box.left, (clientY ?? box.top + box.height / 2) - box.top];
        const scale = Math.min(2.5, Math.max(kLeast, this.view.scale * factor));
        const by = scale / this.view.scale;
        this.view = { x: cx - (cx - this.view.x) * by, y: cy - (cy - this.view.y) * by, scale };
        this.apply();
    }

    /** Two fingers, {clientX, clientY}, were moved. */
    pinch(before, after) {
        const middle = ([a, b]) => [(a.clientX + b.clientX) / 2, (a.clientY + b.clientY) / 2];
        const apart = ([a, b]) => Math.max(Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY), 1);
        const [[x0, y0], [x1, y1]] = [middle(before), middle(after)];
        this.move(x1 - x0, y1 - y0);
        this.zoom(apart(after) / apart(before), x1, y1);
    }

    /** Sees all of it; with `readable`, only as much as can be read, from the result on. */
    fit(readable = false) {
        const box = this.root.getBoundingClientRect();
        if (!this.placed || !box.width) return;
        const scale = Math.min(1, (box.width - 40) / Math.max(this.placed.width, 1), (box.height - 40) / Math.max(this.placed.height, 1));
        const used = Math.max(scale, readable ? kReadable : kLeast);
        const left = (box.width - this.placed.width * used) / 2;
        this.view = { scale: used, x: Math.min(left, box.width - 20 - this.placed.width * used), y: Math.max(20, (box.height - this.placed.height * used) / 2) };
        if (left >= 0) this.view.x = left;
        this.apply();
    }

    /** Whether some of a node is in view. */
    isSeen(id) {
        const at = this.placed.at[id];
        const [x, y] = [at.x * this.view.scale + this.view.x, at.y * this.view.scale + this.view.y];
        return x > -kSize.width && y > -100 && x < this.root.clientWidth && y < this.root.clientHeight;
    }

    /** Brings a node into view. */
    reveal(id) {
        const at = this.placed?.at[id];
        if (!at) return;
        const box = this.root.getBoundingClientRect();
        const [x, y] = [at.x * this.view.scale + this.view.x, at.y * this.view.scale + this.view.y];
        const dx = x < 10 ? 10 - x : Math.min(0, box.width - 10 - kSize.width * this.view.scale - x);
        const dy = y < 10 ? 10 - y : Math.min(0, box.height - 10 - heightOf(this.tab.nodes[id]) * this.view.scale - y);
        if (dx || dy) this.move(dx, dy);
    }

    apply() {
        // What is too small to read need not be drawn.
        this.root.classList.toggle("far", this.view.scale < kFar);
        // While it moves it is a picture of its own, which need not be drawn anew; then it becomes sharp.
        this.world.style.willChange = "transform";
        clearTimeout(this.settling);
        this.settling = setTimeout(() => { this.world.style.willChange = "auto"; }, kSettleMs);
        this.world.style.transform = `translate(${this.view.x}px, ${this.view.y}px) scale(${this.view.scale})`;
    }
}

// Draws a graph as SVG, moves and scales the drawing, and says what is at a point of it.

import { heightOf, kSize, rowsEnd } from "./graph_layout.js";
import { curvePaths, membersOf, short } from "./graph_look.js";
import { arrange } from "./graph_places.js";

const kSvg = "http://www.w3.org/2000/svg";
const kSettleMs = 200, kLeast = 0.12;
/** From these scales on, titles have letters of a size, in the drawing's units, of which a node holds so many: never below 10 px. */
const kBands = [{ scale: 10 / 11, letters: 20 }, { scale: 0.58, letters: 14 }, { scale: 0.37, letters: 9 }, { scale: 0, letters: 0 }];
const kReadable = kBands[0].scale;

function svg(name, attributes = {}, ...children) {
    const made = document.createElementNS(kSvg, name);
    for (const [key, value] of Object.entries(attributes)) if (value !== undefined && value !== false) made.setAttribute(key, value);
    made.append(...children);
    return made;
}

const clip = (text, most) => (text.length > most ? `${text.slice(0, Math.max(most - 1, 0))}${most ? "…" : ""}` : text);

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
        this.frames = svg("g", { class: "frames" });
        this.wires = svg("g", { class: "wires" });
        this.nodes = svg("g", { class: "nodes" });
        this.loose = svg("path", { class: "loose" });
        this.lasso = svg("rect", { class: "lasso", visibility: "hidden" });
        this.inner = svg("g", {}, this.frames, this.wires, this.nodes, this.loose, this.lasso);
        this.world.append(this.inner);
        root.append(this.world);
        this.view = { x: 20, y: 20, scale: 1 };
        this.tab = null;
        this.band = 0;
        this.onmove = () => {};
    }

    /** Shows a tab with its nodes where `own` says (graph_places.js); `marked` are nodes with troubles by line, of a text that
     *  could not be drawn. */
    show(tab, keys, own, selected, port, marked = new Map()) {
        this.tab = tab;
        const folded = new Set(own.folded);
        for (const node of tab.nodes) node.folded = folded.has(keys[node.id]);
        this.placed = arrange(tab.nodes, keys, own);
        this.fitSheet();
        this.frames.replaceChildren(...this.placed.frames.map((frame, i) => this.frame(frame, i)));
        // A click gives the focus to a node, which is drawn anew: keys go on to the graph.
        const focused = this.nodes.contains(document.activeElement);
        this.nodes.replaceChildren(...tab.nodes.filter((node) => !this.placed.hiddenIn.has(node.id)).map((node) => this.node(node, marked.get(node.id))));
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
            if (node.look && !node.folded) made.append(this.look(node, lookOf(node)));
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
        const last = [...selected].at(-1);
        if (last === undefined) this.root.removeAttribute("aria-activedescendant");
        else this.root.setAttribute("aria-activedescendant", `node_${last}`);
        for (const one of this.nodes.children) {
            const is = selected.has(Number(one.dataset.node));
            one.classList.toggle("selected", is);
            one.setAttribute("aria-current", is);
            for (const row of one.querySelectorAll("[data-port]"))
                row.classList.toggle("selected", port !== null && Number(one.dataset.node) === port?.node && Number(row.dataset.port) === port.port);
        }
        for (const one of this.frames.children) {
            const { folded, nodes } = this.placed.frames[one.dataset.frame];
            one.classList.toggle("selected", folded && nodes.some((id) => selected.has(id)));
        }
        for (const wire of this.wires.children)
            wire.classList.toggle("selected", port !== null && Number(wire.dataset.node) === port?.node && Number(wire.dataset.port) === port.port);
    }

    /** Where wires of a node all meet, if it is folded. */
    isNarrow(node) { return node.folded || this.placed.hiddenIn.has(node.id); }

    portAt(node, i) {
        const { x, y } = this.placed.at[node.id];
        if (this.isNarrow(node)) return { x, y: y + kSize.head / 2 };
        return { x, y: y + kSize.head + (i + 0.5) * kSize.row };
    }

    outputAt(node, i) {
        const { x, y } = this.placed.at[node.id];
        return { x: x + kSize.width, y: i === 0 || this.isNarrow(node) ? y + kSize.head / 2 : y + kSize.head + (i - 0.5) * kSize.row };
    }

    static path(from, to) {
        const bend = Math.max(30, Math.abs(to.x - from.x) / 2);
        return `M${from.x} ${from.y} C${from.x + bend} ${from.y} ${to.x - bend} ${to.y} ${to.x} ${to.y}`;
    }

    wire(node, port, i) {
        if (port.from === undefined) return null;
        const from = this.tab.nodes[port.from];
        const hidden = this.placed.hiddenIn.get(node.id);
        if (hidden !== undefined && hidden === this.placed.hiddenIn.get(from.id)) return null;
        const d = GraphDrawing.path(this.outputAt(from, port.output), this.portAt(node, i));
        const type = from.outputs[port.output]?.type ?? "";
        // A wide one below is easier to hit.
        return svg("g", { class: `wire ${familyOf(type)}`, "data-node": node.id, "data-port": i, "data-from": from.id },
            svg("path", { class: "hit", d }), svg("path", { d }));
    }

    node(node, trouble) {
        const { x, y } = this.placed.at[node.id];
        const height = heightOf(node);
        const wrong = trouble ?? node.troubles?.find((t) => t.severity === "error")?.message;
        const warning = node.troubles?.[0]?.message;
        const made = svg("g", {
            class: `node ${node.kind} ${node.role ?? ""} ${wrong ? "wrong" : warning ? "warned" : ""}`, "data-node": node.id, id: `node_${node.id}`, transform: `translate(${x} ${y})`,
            tabindex: -1, role: "group", "aria-label": `${titleOf(node)}${node.folded ? ", collapsed" : ""}${wrong ? `, ${wrong}` : ""}`,
        });
        made.append(
            svg("rect", { class: "box", width: kSize.width, height, rx: 5 }),
            svg("path", { class: "head", d: `M0 ${kSize.head} V5 A5 5 0 0 1 5 0 H${kSize.width - 5} A5 5 0 0 1 ${kSize.width} 5 V${kSize.head} Z` }),
            svg("text", { class: "title", x: 10, y: 16 }, clip(titleOf(node), kBands[this.band].letters)));
        if (wrong || warning || node.help || node.kind === "opaque") made.append(svg("title", {}, wrong ?? warning ?? (node.kind === "opaque" ? node.text : node.help)));
        if (node.folded) {
            const of = (list, way, x) => (list.length ? [svg("circle", { class: `${way} ${familyOf(list[0].type || list[0].wants)}`, cx: x, cy: kSize.head / 2, r: 5, "data-output": way === "out" && 0 })] : []);
            made.append(...of(node.ports, "in", 0), ...of(node.outputs, "out", kSize.width));
            return made;
        }
        node.ports.forEach((port, i) => made.append(this.port(port, i)));
        node.outputs.forEach((output, i) => {
            const at = this.outputAt(node, i);
            made.append(svg("circle", { class: `out ${familyOf(output.type)}`, "data-output": i, cx: at.x - x, cy: at.y - y, r: 5 }));
            if (i > 0) made.append(svg("text", { class: "value", x: kSize.width - 10, y: at.y - y + 4, "text-anchor": "end" }, clip(output.name, 14)));
        });
        if (node.kind === "opaque" && !node.ports.length) made.append(svg("text", { class: "value", x: 10, y: kSize.head + 14 }, "…"));
        return made;
    }

    frame({ name, folded, nodes, box }, i) {
        const made = svg("g", { class: `frame ${folded ? "folded" : ""}`, "data-frame": i, transform: `translate(${box.x} ${box.y})` });
        if (nodes.length === 0) return made;
        made.append(svg("rect", { class: "sheet", width: box.width, height: box.height, rx: 6 }), svg("rect", { class: "bar", width: box.width, height: kSize.head, rx: 6 }),
            svg("text", { class: "fold", x: 9, y: 16 }, folded ? "▸" : "▾"), svg("rect", { class: "hit", width: 26, height: kSize.head, "data-fold": i }, svg("title", {}, folded ? "Expand (Shift+C)" : "Collapse (Shift+C)")),
            svg("text", { class: "title", x: 28, y: 16 }, clip(folded ? `${name} (${nodes.length})` : name, folded ? 17 : Math.floor(box.width / 8))));
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
        const frame = hit.closest("[data-frame]");
        if (!holder && frame && !hit.classList.contains("sheet")) return { frame: Number(frame.dataset.frame), fold: hit.dataset.fold !== undefined };
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
        const { x, y, width, height } = this.placed.bounds;
        const scale = Math.min(1, (box.width - 40) / Math.max(width, 1), (box.height - 40) / Math.max(height, 1));
        const used = Math.max(scale, readable ? kReadable : kLeast);
        const left = (box.width - width * used) / 2;
        const at = { x: left >= 0 ? left : box.width - 20 - width * used, y: Math.max(20, (box.height - height * used) / 2) };
        // Where it is higher than the window, the result is what is seen.
        const result = this.placed.at.at(-1);
        if (height * used > box.height - 40 && result) at.y = Math.min(20, Math.max(box.height - 20 - height * used, box.height / 2 - (result.y - y) * used));
        this.view = { scale: used, x: at.x - x * used, y: at.y - y * used };
        this.apply();
    }

    /** The part of the drawing that is in view. */
    window() {
        const { x, y, scale } = this.view;
        return { x: -x / scale, y: -y / scale, width: this.root.clientWidth / scale, height: this.root.clientHeight / scale };
    }

    /** Brings a point of the drawing to the middle. */
    center({ x, y }) {
        this.view.x = this.root.clientWidth / 2 - x * this.view.scale;
        this.view.y = this.root.clientHeight / 2 - y * this.view.scale;
        this.apply();
    }

    /** A rectangle between two points of the screen, and the nodes that it meets; null: none. */
    showLasso(from, to) {
        this.lasso.setAttribute("visibility", from ? "visible" : "hidden");
        if (!from) return [];
        const [a, b] = [this.toWorld(from.x, from.y), this.toWorld(to.x, to.y)];
        const box = { x: Math.min(a.x, b.x), y: Math.min(a.y, b.y), width: Math.abs(a.x - b.x), height: Math.abs(a.y - b.y) };
        for (const [name, value] of Object.entries(box)) this.lasso.setAttribute(name, value);
        return this.tab.nodes.filter(({ id }) => {
            const at = this.placed.at[id];
            return !this.placed.hiddenIn.has(id) && at.x < box.x + box.width && box.x < at.x + kSize.width && at.y < box.y + box.height && box.y < at.y + heightOf(this.tab.nodes[id]);
        }).map((node) => node.id);
    }

    /** Moves nodes, as a hand drags them: they and their wires alone are drawn anew. */
    carry(ids, dx, dy) {
        const key = ids.join();
        if (this.carried?.key !== key || this.carried.placed !== this.placed) this.carried = this.carriedOf(key, ids);
        const { moved, nodes, wires } = this.carried;
        for (const id of moved) this.placed.at[id] = { x: this.placed.at[id].x + dx, y: this.placed.at[id].y + dy };
        for (const [id, one] of nodes) one.setAttribute("transform", `translate(${this.placed.at[id].x} ${this.placed.at[id].y})`);
        for (const { node, i, from, paths } of wires) {
            const d = GraphDrawing.path(this.outputAt(from, node.ports[i].output), this.portAt(node, i));
            for (const path of paths) path.setAttribute("d", d);
        }
        this.placed.frames.forEach((frame, i) => {
            if (!frame.nodes.length || !frame.nodes.every((id) => moved.has(id))) return;
            frame.box = { ...frame.box, x: frame.box.x + dx, y: frame.box.y + dy };
            this.frames.children[i].setAttribute("transform", `translate(${frame.box.x} ${frame.box.y})`);
        });
        this.onmove();
    }

    /** What is drawn anew of nodes that a hand carries. */
    carriedOf(key, ids) {
        const moved = new Set(ids);
        const nodes = [...this.nodes.children].map((one) => [Number(one.dataset.node), one]).filter(([id]) => moved.has(id));
        const wires = [...this.wires.children].filter(({ dataset: { node, from } }) => moved.has(Number(node)) || moved.has(Number(from)))
            .map((wire) => ({ node: this.tab.nodes[wire.dataset.node], i: Number(wire.dataset.port), from: this.tab.nodes[wire.dataset.from], paths: wire.querySelectorAll("path") }));
        return { key, placed: this.placed, moved, nodes, wires };
    }

    /** The SVG is as large as what is drawn, wherever that begins. */
    fitSheet() {
        const { x, y, width, height } = this.placed.bounds;
        this.world.setAttribute("width", Math.max(width, 1));
        this.world.setAttribute("height", Math.max(height, 1));
        this.inner.setAttribute("transform", `translate(${-x} ${-y})`);
        this.apply();
    }

    /** Letters keep their size on the screen, as far as nodes have room for them. */
    setBand(band) {
        if (band === this.band) return;
        this.band = band;
        this.root.dataset.band = band;
        for (const made of this.nodes.children) made.querySelector(".title").textContent = clip(titleOf(this.tab.nodes[made.dataset.node]), kBands[band].letters);
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
        this.setBand(kBands.findIndex((band) => this.view.scale >= band.scale - 1e-6));
        this.onmove();
        const { x, y } = this.placed?.bounds ?? { x: 0, y: 0 };
        // While it moves it is a picture of its own, which need not be drawn anew; then it becomes sharp.
        this.world.style.willChange = "transform";
        clearTimeout(this.settling);
        this.settling = setTimeout(() => { this.world.style.willChange = "auto"; }, kSettleMs);
        this.world.style.transform = `translate(${this.view.x + x * this.view.scale}px, ${this.view.y + y * this.view.scale}px) scale(${this.view.scale})`;
    }
}

// The graph pane: the fablet's text drawn as nodes and wires. What is done here is sent to the compiler, which answers
// with the text that it makes; the text is all that is kept.

import { postJson } from "./api.js";
import { element } from "./format.js";
import { GraphDrag } from "./graph_drag.js";
import { GraphClips } from "./graph_clips.js";
import { GraphDrawing, titleOf } from "./graph_draw.js";
import { GraphHand } from "./graph_hand.js";
import { GraphInspector } from "./graph_inspector.js";
import { canBeLookedAt, GraphLooks, hasPicture, isTexture, speedText } from "./graph_look.js";
import { GraphMap } from "./graph_map.js";
import { GraphPalette } from "./graph_palette.js";
import { GraphStands } from "./graph_stands.js";
import { GraphWire, nearestIn } from "./graph_wire.js";
import { Pane } from "./panes.js";
import { Split } from "./split.js";

const byId = (id) => document.getElementById(id);
const kDrawMs = 200;

export class GraphPane {
    /** `editor` holds the text; `fail` shows an error of the server; `world` has what uniforms are bound to. */
    constructor(editor, fail, world) {
        this.editor = editor;
        this.fail = fail;
        this.graph = null;
        this.tab = 0;
        this.selected = new Set();
        this.port = null;
        this.drawing = new GraphDrawing(byId("graph_svg"));
        this.map = new GraphMap(byId("graph_map"), this.drawing);
        this.stands = new GraphStands(this);
        this.clips = new GraphClips(this);
        this.wire = new GraphWire(this);
        this.palette = new GraphPalette((entry) => this.add(entry), (action) => postJson("api/picture", { fablet: this.editor.fablet, text: "", action }), (dx) => this.drawing.move(dx, 0));
        this.drag = new GraphDrag((path, more) => this.ask(path, more));
        this.inspector = new GraphInspector({ act: (action) => this.act(action), drag: (action) => this.beginDrag(action), goTo: (node) => this.goTo(node), choose: (port) => this.choosePort(port) });
        this.looks = new GraphLooks({
            ask: (text, action) => postJson("api/look", { fablet: this.editor.fablet, text, action }), show: () => this.showLooks(), ...world,
            tell: (text) => { byId("graph_look_trouble").textContent = text; },
        });
        new Split(byId("graph_split"), byId("stage"), byId("graph"));
        this.pane = new Pane("graph", () => this.opened());
        this.listen();
    }

    get isOpen() { return this.pane.isOpen; }
    get nodes() { return this.graph?.tabs[this.tab]?.nodes ?? []; }
    get keys() { return this.nodes.map((node) => this.keyOf(node)); }
    get chosen() { return [...this.selected]; }

    opened() {
        byId("graph_svg").focus({ preventScroll: true });
        this.draw().then(() => this.drawing.fit(true));
    }

    /** What the loop says: whether a print runs, and how quick the last was. */
    showState(live) {
        this.drag.showState(live);
        this.looks.setBusy(live.phase === "checking" || live.phase === "printing");
        if (live.phase !== "done" || live.print === this.measured?.print) return;
        const before = this.measured?.speed;
        this.measured = { print: live.print, speed: live.mvoxels_per_second };
        byId("graph_speed").textContent = live.mvoxels_per_second ? `${speedText(live.mvoxels_per_second)} voxels/s${before ? `, before ${speedText(before)}` : ""}` : "";
    }

    say(text, isError = true) {
        byId("graph_message").textContent = text;
        byId("graph_message").classList.toggle("trouble", isError);
    }

    async ask(path, more = {}) {
        return postJson(path, { fablet: this.editor.fablet, text: this.editor.text, ...more });
    }

    /** Draws the text as it is now. */
    async draw() {
        if (!this.isOpen || this.editor.fablet < 0) return;
        const text = this.editor.text;
        try {
            const graph = await this.ask("api/graph");
            if (text === this.editor.text) this.take(graph, text);
        } catch (error) {
            this.fail(error);
        }
    }

    take(graph, text) {
        const other = this.fablet !== this.editor.fablet;
        const [hadTab, hadNodes] = [this.graph?.tabs[this.tab]?.name, this.nodes];
        this.fablet = this.editor.fablet;
        // Text that cannot be read as a whole has no graph: the last one stays, with the errors at their nodes.
        this.stale = !graph.whole && this.graph !== null && !other;
        if (this.stale) this.diagnostics = graph.diagnostics;
        else {
            const names = new Set([...this.selected].map((id) => this.keyOf(this.nodes[id])));
            this.graph = graph;
            if (other) this.tab = this.firstTab();
            if (this.tab >= graph.tabs.length) this.tab = 0;
            this.selected = new Set(other ? [] : this.nodes.filter((node) => names.has(this.keyOf(node))).map((node) => node.id));
            if (this.selected.size !== 1 || !this.nodes[[...this.selected][0]].ports[this.port?.port]) this.port = null;
            if (this.port) this.port.node = [...this.selected][0];
            if (!other && hadTab === this.graph.tabs[this.tab]?.name) this.stands.rename(hadNodes);
        }
        this.drawn = text;
        this.show();
        if (other) this.drawing.fit(true);
    }

    firstTab() {
        return Math.max(0, this.graph.tabs.findIndex((tab) => tab.name === "@Volume"));
    }

    keyOf(node, nodes = this.nodes) {
        const same = nodes.filter((other) => other.id < node.id && other.title === node.title && other.outputs[0]?.name === node.outputs[0]?.name);
        return `${node.title} ${node.outputs[0]?.name} ${same.length}`;
    }

    show() {
        const tabs = this.graph.tabs;
        const several = new Set(tabs.map((tab) => tab.fablet).filter(Boolean)).size > 1;
        byId("graph_tabs").replaceChildren(...tabs.map((tab, i) => element("button", {
            role: "tab", "aria-selected": String(i === this.tab), onclick: () => this.setTab(i),
        }, several && tab.fablet ? `${tab.fablet} ${tab.name}` : tab.name)));
        byId("graph_undo").disabled = !this.editor.history.canUndo;
        byId("graph_redo").disabled = !this.editor.history.canRedo;
        byId("graph_stale").hidden = !this.stale;
        const tab = tabs[this.tab];
        if (!tab) return;
        const marked = new Map();
        if (this.stale) {
            for (const d of this.diagnostics) for (const node of tab.nodes) if (node.line === d.line && node.kind !== "input") marked.set(node.id, d.message);
        }
        const isShown = this.looks.isOn && ["@Volume", "@Surface"].includes(tab.name) || this.looks.isOn && !tab.stage;
        for (const node of tab.nodes) node.look = (isShown && hasPicture(node)) || (this.looks.isOn && isTexture(node));
        this.drawing.show(tab, this.keys, this.stands.here, this.selected, this.port, marked);
        this.wantLooks(isShown);
        this.inspector.show(this.graph, this.tab, this.selected, this.port);
        byId("graph_svg").setAttribute("aria-label", `Graph of ${tab.name}: ${tab.nodes.length} nodes`);
    }

    /** Asks for what nodes in view are; where there are many, for those alone. */
    wantLooks(isShown) {
        if (this.stale) return;
        const nodes = this.nodes.filter(canBeLookedAt).map((node) => ({ id: node.id, key: this.keyOf(node), picture: hasPicture(node), seen: this.drawing.isSeen(node.id) }));
        this.looks.want(isShown ? { text: this.drawn, tab: this.tab, name: this.graph.tabs[this.tab].name, stage: this.graph.tabs[this.tab].stage, nodes: nodes.sort((a, b) => b.seen - a.seen) } : null);
        this.showLooks();
    }

    showLooks() {
        const pictureOf = (node) => (isTexture(node) ? this.looks.textureOf(node) : this.looks.pictures.get(this.keyOf(node)));
        this.drawing.showLooks((node) => ({ picture: pictureOf(node), values: this.looks.values.get(this.keyOf(node)) }));
        this.inspector.showValues((node) => this.looks.values.get(this.keyOf(node)));
    }

    /** Draws again what a change of the switch is about. */
    toggleLooks() {
        this.looks.isOn = !this.looks.isOn;
        byId("graph_look").setAttribute("aria-pressed", this.looks.isOn);
        byId("graph_look_trouble").textContent = "";
        if (this.graph) this.show();
    }

    setTab(tab) {
        this.tab = tab;
        this.looks.forget();
        this.selected.clear();
        this.port = null;
        this.show();
        this.drawing.fit(true);
    }

    select(id, more = false) {
        if (!more) this.selected = new Set(id === null ? [] : [id]);
        else if (this.selected.has(id)) this.selected.delete(id);
        else this.selected.add(id);
        this.port = null;
        this.showSelection();
    }

    choosePort(port) {
        if (this.selected.size !== 1 || this.port?.port === port) return;
        this.port = { node: [...this.selected][0], port };
        this.drawing.select(this.selected, this.port);
    }

    showSelection() {
        this.drawing.select(this.selected, this.port);
        this.inspector.show(this.graph, this.tab, this.selected, this.port);
    }

    /** A hand begins to drag a number, of which `action` would make a uniform; what it gets shows values, and ends. */
    beginDrag(action) {
        const { fablet } = this.graph.tabs[this.tab];
        if (!fablet || !byId("graph_save").checked || this.stale || this.editor.text !== this.drawn) return null;
        const known = this.graph.uniforms.filter((one) => one.fablet === fablet).map((one) => one.name);
        this.drag.begin({ action: { tab: this.tab, ...action }, fablet, known });
        return this.drag;
    }

    /** Does one action on the text that is drawn; what it adds is put at a point of the drawing, if there is one. */
    async act(action, at = null) {
        document.body.classList.add("graph_busy");
        this.waiting = (this.waiting ?? 0) + 1;
        const done = await this.actNow(action, at);
        if (--this.waiting === 0) document.body.classList.remove("graph_busy");
        return done;
    }

    async actNow(action, at) {
        if (this.stale) return this.say("the text has errors that hide parts of the graph; mend them first");
        if (this.busy) await this.busy;
        const before = this.editor.text;
        if (before !== this.drawn) await this.draw();
        this.busy = (async () => {
            try {
                const known = new Set(this.nodes.map((node) => this.keyOf(node)));
                const made = await this.ask("api/edit", { action: { tab: this.tab, ...action } });
                // What was typed meanwhile wins; the action can be done again.
                if (before !== this.editor.text) return this.say("the text was changed meanwhile; nothing was done");
                this.say("");
                this.put(made.text);
                this.take(made.graph, made.text);
                if (action.do === "add" || action.do === "paste") {
                    const fresh = this.nodes.filter((node) => !known.has(this.keyOf(node)) && node.root);
                    if (fresh.length) {
                        this.stands.put(fresh.map((node) => node.id), at);
                        this.selected = new Set(action.do === "paste" ? fresh.map((node) => node.id) : [fresh.at(-1).id]);
                        this.port = null;
                        this.showSelection();
                        this.drawing.reveal(fresh.at(-1).id);
                    }
                }
                else if (this.selected.size) this.drawing.reveal(this.chosen[0]);
                return true;
            } catch (error) {
                if (error.status === 422) this.say(error.message);
                else this.fail(error);
                this.inspector.show(this.graph, this.tab, this.selected, this.port);
            }
        })();
        const done = await this.busy;
        this.busy = null;
        return done;
    }

    /** Gives the editor a text; saves it where each change is to be printed. */
    put(text) {
        this.drawn = text;
        this.editor.replace(text);
        if (byId("graph_save").checked) this.editor.save();
    }

    undo() { this.stepped(this.editor.undo()); }
    redo() { this.stepped(this.editor.redo()); }

    stepped(done) {
        if (!done) return;
        if (byId("graph_save").checked) this.editor.save();
        this.draw();
    }

    /** What is taken from the list is put at a point of the drawing, if there is one. */
    async openPalette(at = null) {
        if (!this.graph) return;
        this.addAt = at;
        try {
            const entries = await this.ask("api/palette");
            const port = this.port ? this.nodes[this.port.node]?.ports[this.port.port] : null;
            this.palette.open(entries, port?.begin === undefined ? null : port.type);
        } catch (error) {
            this.fail(error);
        }
    }

    add({ signature, module }, at = this.addAt) {
        const port = this.port;
        this.addAt = null;
        this.palette.close();
        byId("graph_svg").focus();
        if (port && this.nodes[port.node]?.ports[port.port]?.begin !== undefined) return this.act({ do: "insert", ...port, signature, module });
        return this.act({ do: "add", signature, module }, at);
    }

    remove() {
        const nodes = [...this.selected];
        if (nodes.length === 1 && this.port) return this.act({ do: "disconnect", ...this.port });
        if (nodes.length === 1) return this.act({ do: "delete", node: nodes[0] });
        return nodes.length ? this.removeAll(nodes) : this.say("choose a node first");
    }

    /** The last first: what it reads may go with it. One step to undo. */
    async removeAll(nodes) {
        const keys = nodes.sort((a, b) => b - a).map((id) => this.keyOf(this.nodes[id]));
        const { history } = this.editor;
        const steps = history.depth;
        for (const key of keys) {
            const node = this.nodes.find((one) => this.keyOf(one) === key);
            if (node && !(await this.act({ do: "delete", node: node.id }))) break;
        }
        if (history.depth <= steps) return;
        history.joinSince(steps);
        this.select(null);
    }

    group() {
        if (this.selected.size === 0) return this.say("choose nodes first: Shift and a click");
        const name = prompt("The name of the function", "part");
        if (name) this.act({ do: "group", nodes: [...this.selected], text: name });
    }

    goTo(node) {
        const at = node.begin ?? 0;
        const lines = this.editor.text.slice(0, at).split("\n");
        this.editor.goTo({ fablet: this.editor.fablet, line: lines.length, column: [...lines.at(-1)].length + 1 });
    }

    /** The nearest node in a direction of the drawing; with `more` it is chosen besides. */
    walk(dx, dy, more) {
        const placed = this.drawing.placed?.at;
        if (!placed || placed.length === 0) return;
        const now = [...this.selected].at(-1);
        if (now === undefined) return this.select(placed.length - 1);
        const best = nearestIn(placed.map(({ x, y }, id) => ({ x, y, id })), placed[now], [dx, dy])?.id;
        if (best === undefined) return;
        // Last in the order of the set, where the next step begins.
        if (more) this.selected.delete(best);
        this.select(best, more);
        this.drawing.reveal(best);
    }

    /** The next input of the chosen node, or the one before: what Add and Delete are about. */
    nextPort(by) {
        const node = this.nodes[this.chosen[0]];
        const inputs = node?.ports.flatMap((port, i) => (port.begin === undefined ? [] : [i])) ?? [];
        if (this.selected.size !== 1 || !inputs.length) return this.say("choose a node first, with an input that can be changed");
        const at = this.port ? inputs.indexOf(this.port.port) + by : by > 0 ? 0 : -1;
        this.port = { node: node.id, port: inputs[(at + inputs.length) % inputs.length] };
        this.showSelection();
        this.say(`${node.ports[this.port.port].label} of ${titleOf(node)}`, false);
    }

    key(event) {
        const mod = event.ctrlKey || event.metaKey;
        const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
        const keys = {
            ArrowLeft: () => this.walk(-1, 0, event.shiftKey), ArrowRight: () => this.walk(1, 0, event.shiftKey), ArrowUp: () => this.walk(0, -1, event.shiftKey), ArrowDown: () => this.walk(0, 1, event.shiftKey),
            Delete: () => this.remove(), Backspace: () => this.remove(), a: () => this.openPalette(), g: () => this.group(),
            w: () => this.wire.begin(), i: () => this.nextPort(event.shiftKey ? -1 : 1),
            f: () => this.stands.frame(), c: () => this.stands.fold(event.shiftKey),
            Enter: () => byId("inspector").querySelector("input, select, button")?.focus(), t: () => this.selected.size && this.goTo(this.nodes[[...this.selected][0]]),
            0: () => this.drawing.fit(), "+": () => this.drawing.zoom(1.25), "-": () => this.drawing.zoom(0.8), Escape: () => this.select(null),
        };
        const carry = mod && { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key];
        if (!mod && this.wire.key(key)) { /* the wire in hand has it */ }
        else if (carry) this.stands.nudge(...carry);
        else if (mod && key === "d") this.clips.duplicate();
        else if (mod && key === "a") this.chooseAll(this.nodes.map((node) => node.id));
        else if (mod && key === "z") (event.shiftKey ? this.redo() : this.undo());
        else if (mod && key === "y") this.redo();
        else if (mod && key === "s") this.editor.save();
        else if (!mod && keys[key]) keys[key]();
        else return;
        event.preventDefault();
        event.stopPropagation();
    }

    listen() {
        const root = byId("graph_svg");
        new GraphHand(root, this.drawing, this);
        root.addEventListener("keydown", (event) => this.key(event));
        // Back to the graph, with the input that was edited still chosen: Delete and Add are about it.
        byId("inspector").addEventListener("keydown", (event) => {
            if (event.key !== "Escape") return;
            event.stopPropagation();
            root.focus();
        });
        for (const [id, does] of Object.entries({
            graph_add: () => this.openPalette(), graph_group: () => this.group(), graph_undo: () => this.undo(), graph_redo: () => this.redo(),
            graph_fit: () => this.drawing.fit(), graph_delete: () => this.remove(), graph_look: () => this.toggleLooks(), graph_copy: () => this.clips.copy(), graph_paste: () => this.clips.paste(),
            graph_frame: () => this.stands.frame(), graph_fold: () => this.stands.fold(), graph_tidy: () => this.stands.tidy(),
        })) byId(id).addEventListener("click", does);
        byId("graph_over").addEventListener("change", (event) => this.looks.setOver(event.target.value));
        byId("source").addEventListener("input", () => {
            if (this.editor.text === this.drawn) return;
            clearTimeout(this.drawing_soon);
            this.drawing_soon = setTimeout(() => this.draw(), kDrawMs);
        });
        this.editor.onload = () => this.stands.load().then(() => this.draw());
        this.editor.onstep = () => this.stands.stepped();
    }

    chooseAll(ids) {
        this.selected = new Set(ids);
        this.port = null;
        this.drawing.select(this.selected, null);
        this.inspector.show(this.graph, this.tab, this.selected, null);
    }

    click(at, more) {
        if (at.fold) return this.stands.foldFrame(at.frame);
        if (at.frame !== undefined) return this.chooseAll(this.drawing.placed.frames[at.frame].nodes);
        if (at.node === undefined) return this.select(null);
        this.select(at.node, more && !at.wire);
        if (at.port !== undefined && this.selected.size === 1) {
            this.port = { node: at.node, port: at.port };
            this.showSelection();
        }
    }

    /** A wire was dragged from an output or an input, and let go at what is `at`. */
    drop(was, at) {
        const node = this.nodes[was.node];
        const onPort = at?.port !== undefined ? { node: at.node, port: at.port } : null;
        if (was.output !== undefined) {
            if (onPort) this.act({ do: "connect", from: was.node, output: was.output, ...onPort });
            return;
        }
        const port = node.ports[was.port];
        if (port.from === undefined || (onPort && onPort.node === was.node && onPort.port === was.port)) return;
        if (onPort) this.act({ do: "connect", from: port.from, output: port.output, ...onPort });
        else this.act({ do: "disconnect", node: was.node, port: was.port });
    }
}

// Where the nodes of the shown fablet stand, which are folded, and frames: changed by hand, a step of undoing each, and
// kept by the server in a file of its own beside the fablet.

import { getJson, postJson, query } from "./api.js";
import { kSize } from "./graph_layout.js";
import { changed, nothing, placesOf, renamedKeys } from "./graph_places.js";

const kSaveMs = 400, kStep = 20;

export class GraphStands {
    /** `pane` is the graph's (graph.js). */
    constructor(pane) {
        this.pane = pane;
        this.fablet = -1;
        this.lifted = [];
    }

    get history() { return this.pane.editor.history; }
    get places() { return this.history.beside ?? nothing; }
    get tab() { return this.pane.graph?.tabs[this.pane.tab]?.name ?? ""; }
    get here() { return placesOf(this.places, this.tab); }

    /** Takes what is kept of another fablet. */
    async load() {
        const { fablet } = this.pane.editor;
        if (fablet === this.fablet || fablet < 0) return;
        this.fablet = fablet;
        this.history.beside = nothing;
        try {
            const got = await getJson("api/places?" + query({ fablet }));
            if (fablet === this.pane.editor.fablet) this.history.beside = got.tabs ? got : nothing;
        } catch { /* laid out anew */ }
    }

    /** One change by hand, a step to undo; drawn and kept. */
    change(does) {
        this.history.recordBeside(changed(this.places, this.tab, does));
        this.stepped();
    }

    /** Undoing, or another change, has put them elsewhere. */
    stepped() {
        if (this.places === this.drawn) return;
        this.save();
        if (this.pane.isOpen && this.pane.graph) this.pane.show();
    }

    save() {
        this.drawn = this.places;
        clearTimeout(this.timer);
        const { fablet } = this;
        this.timer = setTimeout(() => postJson("api/places", { fablet, places: this.places }).catch(this.pane.fail), kSaveMs);
    }

    /** Nodes that an edit calls otherwise keep their places: where as many stand in the same order as before. */
    rename(before) {
        const { nodes } = this.pane;
        if (before.length !== nodes.length || before.length === 0) return;
        const renamed = new Map();
        before.forEach((node, i) => {
            const [was, is] = [this.pane.keyOf(node, before), this.pane.keyOf(nodes[i])];
            if (was !== is && node.kind === nodes[i].kind) renamed.set(was, is);
        });
        const now = renamedKeys(this.places, this.tab, renamed);
        if (now === this.places || !this.places.tabs[this.tab]) return;
        this.history.beside = now;
        this.save();
    }

    // Moving.

    lift(ids) { this.lifted = [...ids]; this.far = [0, 0]; this.due = [0, 0]; }

    /** A drag comes in more steps than there are frames. */
    carry(dx, dy) {
        this.due = [this.due[0] + dx, this.due[1] + dy];
        if (this.asked) return;
        this.asked = true;
        requestAnimationFrame(() => { this.asked = false; this.carryNow(); });
    }

    carryNow() {
        const [dx, dy] = this.due;
        if (dx === 0 && dy === 0) return;
        this.due = [0, 0];
        this.pane.drawing.carry(this.lifted, dx, dy);
    }

    letGo() {
        this.carryNow();
        this.put(this.lifted, null, true);
        this.lifted = [];
    }

    /** Nodes stay where they are drawn now, or about a point; `step`: undone of its own. */
    put(ids, point = null, step = false) {
        const { at } = this.pane.drawing.placed;
        if (ids.length === 0 || (!point && !step)) return;
        const keys = this.pane.keys;
        const [dx, dy] = point ? [point.x - kSize.width / 2 - at[ids[0]].x, point.y - kSize.head / 2 - at[ids[0]].y] : [0, 0];
        const put = ({ at: before }) => ({ at: { ...before, ...Object.fromEntries(ids.map((id) => [keys[id], [Math.round(at[id].x + dx), Math.round(at[id].y + dy)]])) } });
        if (step) return this.change(put);
        this.history.beside = changed(this.places, this.tab, put);  // one step with what has added them
        this.stepped();
    }

    nudge(dx, dy) {
        const ids = this.pane.chosen;
        if (ids.length === 0) return;
        this.pane.drawing.carry(ids, dx * kStep, dy * kStep);
        this.put(ids, null, true);
        this.pane.drawing.reveal(ids.at(-1));
    }

    /** All are laid out again; frames and what is folded stay. */
    tidy() {
        if (Object.keys(this.here.at).length) this.change(() => ({ at: {} }));
        this.pane.drawing.fit(true);
    }

    // Frames, and folding.

    frameOf(ids) { return this.here.frames.findIndex((frame) => ids.some((id) => frame.nodes.includes(this.pane.keys[id]))); }

    /** Puts a frame around the chosen nodes; takes away one that holds just these. */
    frame() {
        const { keys, chosen } = this.pane;
        if (chosen.length === 0) return this.pane.say("choose nodes first: Shift and a click, or Shift and a drag");
        const names = chosen.map((id) => keys[id]);
        const same = this.here.frames.findIndex((frame) => frame.nodes.length === names.length && frame.nodes.every((key) => names.includes(key)));
        if (same >= 0) return this.change(({ frames }) => ({ frames: frames.filter((_, i) => i !== same) }));
        const name = prompt("What the frame is called", "part");
        if (name) this.change(({ frames }) => ({ frames: [...frames, { name, nodes: names, folded: false }] }));
    }

    nameFrame(i) {
        const name = prompt("What the frame is called", this.here.frames[i].name);
        if (name) this.change(({ frames }) => ({ frames: frames.map((one, at) => (at === i ? { ...one, name } : one)) }));
    }

    foldFrame(i) {
        if (i >= 0) this.change(({ frames }) => ({ frames: frames.map((one, at) => (at === i ? { ...one, folded: !one.folded } : one)) }));
    }

    /** Collapses the chosen nodes, or expands them if all are; with `around` their frame. */
    fold(around = false) {
        const { keys, chosen } = this.pane;
        if (chosen.length === 0) return this.pane.say("choose a node first");
        const hidden = this.pane.drawing.placed.hiddenIn.has(chosen[0]);
        if (around || hidden) {
            const i = this.frameOf(chosen);
            return i < 0 ? this.pane.say("these nodes are in no frame; F makes one") : this.foldFrame(i);
        }
        const names = chosen.map((id) => keys[id]);
        const all = names.every((key) => this.here.folded.includes(key));
        this.change(({ folded }) => ({ folded: all ? folded.filter((key) => !names.includes(key)) : [...new Set([...folded, ...names])] }));
    }
}

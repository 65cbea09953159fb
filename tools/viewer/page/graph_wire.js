// A wire by keyboard: from the chosen node to the nearest input that may take it, or to another by arrows.

import { titleOf } from "./graph_draw.js";
import { mayTake } from "./graph_palette.js";

const kWays = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** The inputs that an output may go to, those of its very type first, then the nearest; `place` says where an input is. */
export function inputsFor(nodes, from, output, place, start) {
    const { type } = nodes[from].outputs[output];
    const before = new Set([from]);  // what it is made of: a wire there would be a loop
    const grow = (id) => { for (const port of nodes[id].ports) if (port.from !== undefined && !before.has(port.from)) { before.add(port.from); grow(port.from); } };
    grow(from);
    const found = nodes.flatMap((node) => (before.has(node.id) ? [] : node.ports.flatMap((port, i) => {
        const wants = port.wants || port.type;
        const has = port.from === from && port.output === output;
        if (port.begin === undefined || has || !mayTake(wants, type)) return [];
        const { x, y } = place(node, i);
        return [{ node: node.id, port: i, x, y, exact: wants === type, far: Math.hypot(x - start.x, y - start.y) }];
    })));
    return found.sort((a, b) => b.exact - a.exact || a.far - b.far);
}

/** Of `places` the nearest to `now` in a direction; undefined: there is none. */
export function nearestIn(places, now, [dx, dy]) {
    let best, least = Infinity;
    for (const one of places) {
        const [ax, ay] = [one.x - now.x, one.y - now.y];
        const along = ax * dx + ay * dy;
        const cost = along + 3 * Math.abs(ax * dy + ay * dx);
        if (along > 0 && cost < least) [least, best] = [cost, one];
    }
    return best;
}

export class GraphWire {
    /** `pane` is the graph's (graph.js). */
    constructor(pane) {
        this.pane = pane;
        this.from = null;
    }

    begin() {
        const { pane } = this;
        const { drawing, nodes, chosen } = pane;
        const node = nodes[chosen[0]];
        if (chosen.length !== 1 || !node.outputs.length) return pane.say("choose a node first, whose output the wire comes from");
        const start = drawing.outputAt(node, 0);
        const shown = nodes.filter((one) => !drawing.placed.hiddenIn.has(one.id));
        const places = inputsFor(nodes, node.id, 0, (one, i) => drawing.portAt(one, i), start).filter(({ node: id }) => shown.includes(nodes[id]));
        if (!places.length) return pane.say(`nothing may take what ${titleOf(node)} gives`);
        Object.assign(this, { from: node.id, start, places });
        this.point(places[0]);
    }

    point(at) {
        const { pane, start } = this;
        this.at = at;
        pane.drawing.drag(start, at);
        pane.drawing.select(pane.selected, { node: at.node, port: at.port });
        pane.drawing.reveal(at.node);
        const node = pane.nodes[at.node];
        pane.say(`a wire to ${node.ports[at.port].label} of ${titleOf(node)}: Enter connects, arrows go to another input, Escape leaves it`, false);
    }

    end() {
        this.from = null;
        this.pane.drawing.drag(null);
        this.pane.say("");
        this.pane.showSelection();
    }

    /** Whether a key was one for the wire in hand. */
    key(key) {
        if (this.from === null) return false;
        const { pane, from, at } = this;
        if (kWays[key]) {
            const next = nearestIn(this.places, at, kWays[key]);
            if (next) this.point(next);
            return true;
        }
        this.end();
        if (key !== "Enter") return key === "Escape";
        pane.select(at.node);
        pane.act({ do: "connect", from, output: 0, node: at.node, port: at.port });
        return true;
    }
}

// What a hand does on the drawing of the graph: by mouse, pen or fingers.

const kClick = 4, kLongMs = 550;

export class GraphHand {
    /** `pane` does what is asked for (graph.js). */
    constructor(root, drawing, pane) {
        Object.assign(this, { root, drawing, pane, hold: null, fingers: new Map() });
        const on = (name, does, options) => root.addEventListener(name, does, options);
        on("pointerdown", (event) => this.down(event));
        on("pointermove", (event) => this.move(event));
        on("pointerup", (event) => this.up(event));
        on("pointercancel", (event) => this.cancel(event));
        on("dblclick", (event) => this.twice(event));
        on("contextmenu", (event) => {
            event.preventDefault();
            if (event.pointerType !== "touch") this.list(event);  // a long press is timed here, as not all browsers tell it
        });
        on("wheel", (event) => {
            event.preventDefault();
            drawing.zoom(Math.exp(-event.deltaY / 400), event.clientX, event.clientY);
        }, { passive: false });
        on("dragover", (event) => event.preventDefault());
        on("drop", (event) => {
            event.preventDefault();
            const text = event.dataTransfer.getData("text/x-openfl");
            if (!text) return;
            const at = drawing.at(event.clientX, event.clientY);
            pane.port = at?.port === undefined ? null : { node: at.node, port: at.port };
            pane.add(JSON.parse(text), drawing.toWorld(event.clientX, event.clientY));
        });
    }

    /** The list of nodes, for where the hand is: a wire, or a place. */
    list(event) {
        const at = this.drawing.at(event.clientX, event.clientY);
        if (at?.wire) this.pane.click(at, false);
        this.cancelHold();
        this.pane.openPalette(this.drawing.toWorld(event.clientX, event.clientY));
    }

    down(event) {
        this.root.focus({ preventScroll: true });
        if (event.button === 2) return;
        this.fingers.set(event.pointerId, event);
        this.root.setPointerCapture(event.pointerId);
        clearTimeout(this.pressing);
        if (this.fingers.size > 1) return this.cancelHold();
        if (event.pointerType === "touch") this.pressing = setTimeout(() => { if (this.hold && !this.hold.moved) this.list(event); }, kLongMs);
        const at = event.button === 1 ? {} : this.drawing.at(event.clientX, event.clientY);
        this.hold = { x: event.clientX, y: event.clientY, lastX: event.clientX, lastY: event.clientY, moved: false, ...at };
    }

    move(event) {
        const { hold, drawing, pane } = this;
        if (this.fingers.size === 2 && this.fingers.has(event.pointerId)) {
            const before = [...this.fingers.values()];
            this.fingers.set(event.pointerId, event);
            drawing.pinch(before, [...this.fingers.values()]);
        }
        if (!hold) return;
        if (Math.hypot(event.clientX - hold.x, event.clientY - hold.y) > kClick) hold.moved = true;
        if (!hold.moved) return;
        const node = hold.node === undefined || hold.wire ? null : pane.nodes[hold.node];
        if (!hold.does) hold.does = this.kindOf(hold, node, event);
        const [dx, dy] = [event.clientX - hold.lastX, event.clientY - hold.lastY];
        [hold.lastX, hold.lastY] = [event.clientX, event.clientY];
        if (hold.does === "wire") {
            const from = hold.output !== undefined ? drawing.outputAt(node, hold.output) : drawing.outputAt(pane.nodes[node.ports[hold.port].from], node.ports[hold.port].output);
            drawing.drag(from, drawing.toWorld(event.clientX, event.clientY));
        } else if (hold.does === "nodes") pane.stands.carry(dx / drawing.view.scale, dy / drawing.view.scale);
        else if (hold.does === "lasso") pane.chooseAll(drawing.showLasso(hold, { x: event.clientX, y: event.clientY }));
        else drawing.move(dx, dy);
    }

    /** What a drag that begins here does. */
    kindOf(hold, node, event) {
        const { pane } = this;
        if (node && hold.output !== undefined) return "wire";
        if (node && hold.dot && node.ports[hold.port]?.from !== undefined) return "wire";
        if (node || hold.frame !== undefined) {
            const ids = node ? (pane.selected.has(node.id) ? pane.chosen : [node.id]) : this.drawing.placed.frames[hold.frame].nodes;
            pane.stands.lift(ids);
            return "nodes";
        }
        return event.shiftKey && !hold.wire ? "lasso" : "move";
    }

    up(event) {
        const was = this.hold;
        this.hold = null;
        this.fingers.delete(event.pointerId);
        this.drawing.drag(null);
        clearTimeout(this.pressing);
        if (!was) return;
        if (!was.moved) return this.pane.click(was, event.shiftKey);
        if (was.does === "wire") this.pane.drop(was, this.drawing.at(event.clientX, event.clientY));
        if (was.does === "nodes") this.pane.stands.letGo();
        if (was.does === "lasso") this.drawing.showLasso(null);
    }

    cancelHold() {
        if (this.hold?.does === "nodes") this.pane.stands.letGo();
        if (this.hold?.does === "lasso") this.drawing.showLasso(null);
        this.hold = null;
        this.drawing.drag(null);
    }

    cancel(event) {
        this.fingers.delete(event.pointerId);
        this.cancelHold();
    }

    twice(event) {
        const at = this.drawing.at(event.clientX, event.clientY);
        if (at?.frame !== undefined) { if (!at.fold) this.pane.stands.nameFrame(at.frame); }
        else if (at?.node !== undefined && !at.wire) this.pane.goTo(this.pane.nodes[at.node]);
        else this.list(event);
    }
}

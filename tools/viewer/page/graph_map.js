// A small map of the graph, where not all of it is in view: what is dragged there comes into view.

import { heightOf, kSize } from "./graph_layout.js";

const kWidth = 168, kHeight = 96, kPaceMs = 60;

export class GraphMap {
    constructor(canvas, drawing) {
        Object.assign(this, { canvas, drawing });
        const go = (event) => {
            if (!canvas.hasPointerCapture(event.pointerId)) return;
            const box = canvas.getBoundingClientRect();
            drawing.center(this.back(event.clientX - box.left, event.clientY - box.top));
        };
        canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); go(event); });
        canvas.addEventListener("pointermove", go);
        drawing.onmove = () => this.soon();
        new ResizeObserver(() => this.soon()).observe(drawing.root);
    }

    soon() {
        if (this.asked) return;
        this.asked = true;
        setTimeout(() => requestAnimationFrame(() => { this.asked = false; this.draw(); }), kPaceMs);
    }

    back(x, y) { return { x: this.from.x + x / this.scale, y: this.from.y + y / this.scale }; }

    draw() {
        const { drawing, canvas } = this;
        const window = drawing.window();
        const all = drawing.placed?.bounds;
        const inView = !all || (all.x >= window.x - 1 && all.y >= window.y - 1 && all.x + all.width <= window.x + window.width + 1 && all.y + all.height <= window.y + window.height + 1);
        canvas.hidden = inView || drawing.root.clientWidth < 420;
        if (canvas.hidden) return;
        this.scale = Math.min(kWidth / Math.max(all.width, 1), kHeight / Math.max(all.height, 1), 0.2);
        this.from = { x: all.x - (kWidth / this.scale - all.width) / 2, y: all.y - (kHeight / this.scale - all.height) / 2 };
        const ratio = devicePixelRatio || 1;
        [canvas.width, canvas.height] = [kWidth * ratio, kHeight * ratio];
        const pen = canvas.getContext("2d");
        const style = getComputedStyle(canvas);
        pen.scale(ratio * this.scale, ratio * this.scale);
        pen.translate(-this.from.x, -this.from.y);
        pen.fillStyle = style.getPropertyValue("--text");
        pen.globalAlpha = 0.45;
        for (const node of drawing.tab.nodes) {
            if (drawing.placed.hiddenIn.has(node.id)) continue;
            const { x, y } = drawing.placed.at[node.id];
            pen.fillRect(x, y, kSize.width, heightOf(node));
        }
        pen.globalAlpha = 1;
        pen.strokeStyle = style.getPropertyValue("--accent");
        pen.lineWidth = 1.5 / this.scale;
        for (const { box, nodes } of drawing.placed.frames) if (nodes.length) pen.strokeRect(box.x, box.y, box.width, box.height);
        pen.lineWidth = 2.5 / this.scale;
        pen.strokeRect(window.x, window.y, window.width, window.height);
    }
}

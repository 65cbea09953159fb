// The bar between the preview and the graph: dragged, or moved by arrows, it gives one of them more room.

const kFirst = 1.3, kLeast = 0.25, kMost = 4, kStep = 1.15;

export class Split {
    /** `bar` stands above `below`, whose share of the room that both have is `share` to 1. */
    constructor(bar, above, below) {
        Object.assign(this, { bar, below });
        this.set(kFirst);
        bar.addEventListener("pointerdown", (event) => bar.setPointerCapture(event.pointerId));
        bar.addEventListener("pointermove", (event) => {
            if (!bar.hasPointerCapture(event.pointerId)) return;
            const [one, other] = [above.getBoundingClientRect(), below.getBoundingClientRect()];
            const between = other.top - one.bottom;
            this.set((other.bottom - event.clientY) / Math.max(event.clientY - between - one.top, 1));
        });
        bar.addEventListener("dblclick", () => this.set(kFirst));
        bar.addEventListener("keydown", (event) => {
            if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
            this.set(event.key === "ArrowUp" ? this.share * kStep : this.share / kStep);
            event.preventDefault();
            event.stopPropagation();
        });
    }

    set(share) {
        this.share = Math.min(Math.max(share, kLeast), kMost);
        this.below.parentElement.style.setProperty("--below", `${this.share}fr`);
        this.bar.setAttribute("aria-valuenow", Math.round(100 * this.share / (1 + this.share)));
    }
}

// A cursor for who has no mouse: arrows move it over the picture, Enter chooses what is under it.

const kStep = 8;
const kFar = 40;
const kMoves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Cursor {
    /** `showing` returns the view: its canvas, gridStep(), choose(x, y) and hoverAt(x, y). */
    constructor(mark, showing) {
        this.mark = mark;
        this.showing = showing;
        this.place = null;
        mark.parentElement.addEventListener("pointerdown", () => this.hide());
    }

    get shown() { return this.place !== null; }

    hide() {
        this.place = null;
        this.mark.hidden = true;
    }

    begin() {
        const { canvas } = this.showing();
        this.place = [canvas.clientWidth / 2, canvas.clientHeight / 2];
        canvas.focus();
        this.draw();
    }

    /** Whether the key was one for the cursor. */
    key(event) {
        if (event.key === "Enter") {
            if (!this.shown) this.begin();
            else this.showing().choose(...this.place);
        } else if (this.shown && event.key === "Escape") {
            this.hide();
        } else if (this.shown && kMoves[event.key] && !event.shiftKey) {
            this.moveBy(kMoves[event.key], this.showing().gridStep(kStep));
        } else if (this.shown && kMoves[event.key]) {
            this.moveBy(kMoves[event.key], [kFar, kFar]);
        } else {
            return false;
        }
        return true;
    }

    moveBy(way, step) {
        const { canvas } = this.showing();
        const limits = [canvas.clientWidth, canvas.clientHeight];
        this.place = this.place.map((v, i) => Math.min(Math.max(v + way[i] * step[i], 0), limits[i]));
        this.draw();
    }

    draw() {
        this.mark.hidden = false;
        this.mark.style.translate = `${this.place[0]}px ${this.place[1]}px`;
        this.showing().hoverAt(...this.place);
    }
}

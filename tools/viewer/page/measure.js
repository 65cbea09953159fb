// Measuring: two points, in mm of the print, and what lies between them.

import { axisNames, describe, lengthText } from "./format.js";

const byId = (id) => document.getElementById(id);

export class Measure {
    /** `changed` is called when the points have changed. */
    constructor(changed) {
        this.changed = changed;
        this.on = false;
        this.points = [];
        byId("measure").addEventListener("click", () => this.toggle());
        byId("measure_clear").addEventListener("click", () => this.set([]));
        this.show();
    }

    toggle(on = !this.on) {
        this.on = on;
        this.show();
    }

    /** A third point begins anew. */
    add(point) {
        this.set(this.points.length === 2 ? [point] : [...this.points, point]);
    }

    set(points) {
        this.points = points;
        this.show();
        this.changed();
    }

    get along() { return this.points[1].map((v, a) => v - this.points[0][a]); }
    get text() { return this.points.length < 2 ? "" : lengthText(Math.hypot(...this.along)); }

    show() {
        byId("measure").setAttribute("aria-pressed", this.on);
        byId("canvases").classList.toggle("measuring", this.on);
        byId("measure_panel").hidden = !this.on && this.points.length === 0;
        byId("measure_clear").hidden = this.points.length === 0;
        const place = (point) => point.map((v) => v.toFixed(3)).join(", ");
        const rows = this.points.map((point, i) => [i ? "To" : "From", place(point)]);
        if (this.points.length < 2) rows.push([this.points.length ? "Choose the other point." : "Choose two points in the picture.", "", true]);
        else rows.push(["Distance", this.text], ...axisNames.map((axis, a) => [`along ${axis}`, `${this.along[a].toFixed(3)} mm`]));
        describe(byId("measured"), rows);
    }
}

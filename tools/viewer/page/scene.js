// What is drawn around the volume: its box with lengths, cut planes, axes, the picked voxel and what is measured.
// Edges behind the print lie on a canvas below it, all else on one above.

import { axisNames, lengthText, roundLength } from "./format.js";

const kAxisColors = ["--axis_x", "--axis_y", "--axis_z"];
const kAxesRadius = 34;
/** From the lower right corner to the middle of the axes, in CSS pixels. */
const kAxesPlace = [58, 66];
const kDiscRadius = kAxesRadius + 14;
/** Half of a label's height. */
const kLabelHalf = 9;

/** The middle of the axes on a canvas, and their tips with the standpoint that looks along each. */
export function axesOf(look) {
    const middle = [look.width - kAxesPlace[0], look.height - kAxesPlace[1]];
    const tips = [];
    for (let a = 0; a < 3; ++a) {
        for (const sign of [1, -1]) {
            tips.push({
                axis: a, sign, place: [middle[0] + sign * look.right[a] * kAxesRadius, middle[1] - sign * look.up[a] * kAxesRadius],
                depth: sign * look.towards[a], stand: [["right", "left"], ["back", "front"], ["top", "bottom"]][a][sign > 0 ? 0 : 1],
            });
        }
    }
    tips.sort((p, q) => p.depth - q.depth);
    return { middle, tips };
}

/** The place nearest to x, y, to its left or below, where a label of that half width lies beside the disc of the axes. */
export function besideAxes(look, x, y, half) {
    const [cx, cy] = axesOf(look).middle;
    const left = (at) => {
        const high = Math.max(Math.abs(at - cy) - kLabelHalf, 0);
        if (high >= kDiscRadius || x - half >= cx + kDiscRadius) return x;
        return Math.min(x, cx - Math.sqrt(kDiscRadius ** 2 - high ** 2) - half);
    };
    let best = [left(y), y];
    for (let at = y; at <= look.height - kLabelHalf - 3; ++at) {
        if (Math.hypot(left(at) - x, at - y) < Math.hypot(best[0] - x, best[1] - y)) best = [left(at), at];
    }
    return best;
}

/** The edges of a box as pairs of corners, each with whether it is on the side of the viewer. */
function edgesOf(low, high, towards) {
    const edges = [];
    for (let a = 0; a < 3; ++a) {
        const [b, c] = [(a + 1) % 3, (a + 2) % 3];
        for (const inB of [0, 1]) {
            for (const inC of [0, 1]) {
                const from = [0, 0, 0], to = [0, 0, 0];
                [from[a], to[a]] = [low[a], high[a]];
                from[b] = to[b] = inB ? high[b] : low[b];
                from[c] = to[c] = inC ? high[c] : low[c];
                const seen = (axis, upper) => (upper ? towards[axis] > 1e-3 : towards[axis] < -1e-3);
                edges.push({ axis: a, from, to, front: seen(b, inB) || seen(c, inC), rim: seen(b, inB) !== seen(c, inC) });
            }
        }
    }
    return edges;
}

export class Scene {
    /** `below` and `above` are the canvases. */
    constructor(below, above) {
        this.below = below;
        this.above = above;
    }

    /** `what` has size, low, high (mm from the middle), cuts (by axis), picked and measured (points), and print. */
    draw(look, what) {
        const style = getComputedStyle(document.body);
        const [under, over] = [this.below, this.above].map((canvas) => this.begin(canvas, look));
        const cut = what.cuts.some(Boolean);
        // Of what was cut away a trace.
        over.globalAlpha = cut ? 0.3 : 1;
        for (const edge of edgesOf(what.size.map((s) => -s / 2), what.size.map((s) => s / 2), look.towards))
            this.line(edge.front ? over : under, look, [edge.from, edge.to], style.getPropertyValue("--line"), edge.front ? 1 : 0.8);
        over.globalAlpha = 1;
        if (cut) this.drawCuts(over, look, what, style);
        this.drawLengths(over, look, what, style);
        this.drawPicked(over, look, what, style);
        this.drawMeasured(over, look, what, style);
        this.drawAxes(over, look, style);
        this.drawScaleBar(over, look, style);
    }

    begin(canvas, look) {
        const ratio = devicePixelRatio || 1;
        const [w, h] = [Math.round(look.width * ratio), Math.round(look.height * ratio)];
        if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
        const c = canvas.getContext("2d");
        c.setTransform(ratio, 0, 0, ratio, 0, 0);
        c.clearRect(0, 0, look.width, look.height);
        c.lineCap = c.lineJoin = "round";
        return c;
    }

    line(c, look, points, color, width) {
        c.beginPath();
        points.forEach((point, i) => c[i ? "lineTo" : "moveTo"](...look.toCanvas(point)));
        c.strokeStyle = color;
        c.lineWidth = width;
        c.stroke();
    }

    /** The frame of each cut. */
    drawCuts(c, look, { low, high, cuts }, style) {
        for (let a = 0; a < 3; ++a) {
            if (!cuts[a]) continue;
            const at = look.towards[a] > 0 || (a === 2 && look.towards[2] >= 0) ? high[a] : low[a];
            const [b, d] = [(a + 1) % 3, (a + 2) % 3];
            const corners = [[low, low], [high, low], [high, high], [low, high], [low, low]].map(([p, q]) => {
                const corner = [0, 0, 0];
                [corner[a], corner[b], corner[d]] = [at, p[b], q[d]];
                return corner;
            });
            this.line(c, look, corners, style.getPropertyValue(kAxisColors[a]), 1.2);
        }
    }

    /** How long the box is along each axis, beside the edge of its rim that is lowest on the canvas. */
    drawLengths(c, look, { size }, style) {
        const edges = edgesOf(size.map((s) => -s / 2), size.map((s) => s / 2), look.towards);
        const middle = look.toCanvas([0, 0, 0]);
        for (let a = 0; a < 3; ++a) {
            const seen = edges.filter((edge) => edge.axis === a && edge.rim).map((edge) => {
                const [p, q] = [look.toCanvas(edge.from), look.toCanvas(edge.to)];
                return { p, q, y: p[1] + q[1] + (a === 2 ? p[0] * 3 : 0) };
            });
            if (seen.length === 0) continue;
            const { p, q } = seen.reduce((best, edge) => (edge.y > best.y ? edge : best));
            if (Math.hypot(q[0] - p[0], q[1] - p[1]) < 40) continue;
            const at = [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
            const away = Math.hypot(at[0] - middle[0], at[1] - middle[1]) || 1;
            if (at[0] < 0 || at[0] > look.width || at[1] < 0 || at[1] > look.height) continue;
            const x = Math.min(Math.max(at[0] + (at[0] - middle[0]) / away * 24, 40), look.width - 40);
            const y = Math.min(Math.max(at[1] + (at[1] - middle[1]) / away * 14, 12), look.height - 12);
            const text = `${axisNames[a]} ${lengthText(size[a])}`;
            this.label(c, text, ...besideAxes(look, x, y, this.labelWidth(c, text) / 2), style.getPropertyValue(kAxisColors[a]), style);
        }
    }

    labelWidth(c, text) {
        c.font = "12px system-ui, sans-serif";
        return c.measureText(text).width + 8;
    }

    label(c, text, x, y, color, style) {
        const width = this.labelWidth(c, text);
        c.globalAlpha = 0.8;
        c.fillStyle = style.getPropertyValue("--panel");
        c.fillRect(x - width / 2, y - kLabelHalf, width, 2 * kLabelHalf);
        c.globalAlpha = 1;
        c.fillStyle = color;
        c.textAlign = "center";
        c.textBaseline = "middle";
        c.fillText(text, x, y + 0.5);
    }

    drawPicked(c, look, { picked }, style) {
        if (!picked) return;
        const [x, y] = look.toCanvas(picked);
        c.beginPath();
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
            c.moveTo(x + dx * 5, y + dy * 5);
            c.lineTo(x + dx * 14, y + dy * 14);
        }
        // Seen on any material.
        for (const [color, width] of [["--panel", 4], ["--accent", 1.5]]) {
            c.strokeStyle = style.getPropertyValue(color);
            c.lineWidth = width;
            c.stroke();
        }
    }

    drawMeasured(c, look, { measured, measuredText }, style) {
        const places = measured.map((point) => look.toCanvas(point));
        strokeMeasure(c, places, style);
        if (places.length === 2)
            this.label(c, measuredText, (places[0][0] + places[1][0]) / 2, (places[0][1] + places[1][1]) / 2 - 14, style.getPropertyValue("--text"), style);
    }

    drawAxes(c, look, style) {
        const { middle, tips } = axesOf(look);
        c.beginPath();
        c.arc(...middle, kDiscRadius, 0, 2 * Math.PI);
        c.globalAlpha = 0.72;
        c.fillStyle = style.getPropertyValue("--panel");
        c.fill();
        c.globalAlpha = 1;
        c.font = "600 11px system-ui, sans-serif";
        c.textAlign = "center";
        c.textBaseline = "middle";
        for (const { axis, sign, place, depth } of tips) {
            const color = style.getPropertyValue(kAxisColors[axis]);
            c.globalAlpha = depth < -0.2 ? 0.55 : 1;
            c.strokeStyle = c.fillStyle = color;
            c.lineWidth = 2;
            if (sign > 0) {
                c.beginPath();
                c.moveTo(...middle);
                c.lineTo(...place);
                c.stroke();
            }
            c.beginPath();
            c.arc(...place, sign > 0 ? 8 : 5, 0, 2 * Math.PI);
            if (sign > 0) {
                c.fill();
                c.fillStyle = style.getPropertyValue("--panel");
                c.fillText(axisNames[axis], place[0], place[1] + 0.5);
            } else {
                c.lineWidth = 1.5;
                c.stroke();
            }
        }
        c.globalAlpha = 1;
    }

    drawScaleBar(c, look, style) {
        const length = roundLength(140 / look.scale);
        const w = length * look.scale;
        const y = look.height - 18;
        c.globalAlpha = 0.82;
        c.fillStyle = style.getPropertyValue("--panel");
        c.fillRect(8, y - 28, w + 20, 36);
        c.globalAlpha = 1;
        c.fillStyle = style.getPropertyValue("--text");
        c.fillRect(18, y - 3, w, 3);
        c.fillRect(18, y - 8, 1, 8);
        c.fillRect(17 + w, y - 8, 1, 8);
        c.font = "12px system-ui, sans-serif";
        c.textAlign = "left";
        c.textBaseline = "alphabetic";
        c.fillText(lengthText(length), 18, y - 12);
    }
}

/** The points of a measure and the line between them, at places of a canvas. */
export function strokeMeasure(c, places, style) {
    if (places.length === 0) return;
    c.beginPath();
    places.forEach((place, i) => c[i ? "lineTo" : "moveTo"](...place));
    for (const [x, y] of places) {
        c.moveTo(x + 4, y);
        c.arc(x, y, 4, 0, 2 * Math.PI);
    }
    for (const [color, width] of [["--panel", 4.5], ["--measure", 2]]) {
        c.strokeStyle = style.getPropertyValue(color);
        c.lineWidth = width;
        c.stroke();
    }
}

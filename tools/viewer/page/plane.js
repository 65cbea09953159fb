// Slices and cuts: a canvas of tiles, each fetched at the resolution that is shown. A new plane appears once all its
// visible tiles are there, so that nothing flickers while one leafs through a print; only the last wish is fetched.

import { getPicture, query } from "./api.js";
import { axisNames, lengthText, millimetres, roundLength } from "./format.js";
import { strokeMeasure } from "./scene.js";

const kTile = 512;
const kMostTiles = 96;
const kAtOnce = 4;
/** Which axes of the print run right and up in a plane across an axis. */
const kAxes = { x: [1, 2], y: [0, 2], z: [0, 1] };

export class PlaneView {
    /**
     * `model` has print(), palette(), which, at (by axis), picked and measure; `events` has pick, measure, hover, step,
     * zoomed, moved, ready and fail.
     */
    constructor(canvas, model, events) {
        this.canvas = canvas;
        this.context = canvas.getContext("2d");
        this.model = model;
        this.events = events;
        this.axis = "z";
        this.tiles = new Map();
        this.shown = null;  // the plane on the canvas, with its stage of refinement
        this.loading = false;
        this.views = {};    // by axis: centre in mm of the plane, pixels a mm
        this.pointers = new Map();
        this.listen();
        new ResizeObserver(() => this.resize()).observe(canvas);
        this.resize();
    }

    get axes() { return kAxes[this.axis]; }
    get view() { return this.views[this.axis] ?? this.fitted(); }

    resize() {
        this.ratio = devicePixelRatio || 1;
        const { clientWidth: w, clientHeight: h } = this.canvas;
        if (w === 0) return;
        this.canvas.width = Math.round(w * this.ratio);
        this.canvas.height = Math.round(h * this.ratio);
        this.update();
    }

    fitted() {
        const print = this.model.print();
        const [a, b] = this.axes;
        const w = print.size[a] * print.pitch_mm[a], h = print.size[b] * print.pitch_mm[b];
        const width = this.canvas.clientWidth || 1, height = this.canvas.clientHeight || 1;
        return { x: w / 2, y: h / 2, scale: Math.min(Math.max(width - 40, 10) / w, Math.max(height - 90, 10) / h) };
    }

    fit() {
        delete this.views[this.axis];
        this.update();
    }

    /** What the address keeps of the view: its middle and scale, where it is not the whole. */
    text() {
        const view = this.views[this.axis];
        return view && [view.x, view.y, view.scale].map((v) => Number(v.toPrecision(6))).join(",");
    }

    set([x, y, scale]) { this.views[this.axis] = { x, y, scale }; }

    /** Zooms about a point of the canvas, in CSS pixels from its middle. */
    zoom(factor, dx = 0, dy = 0) {
        const view = this.view;
        const print = this.model.print();
        const finest = Math.min(...this.axes.map((a) => print.pitch_mm[a]));
        const scale = Math.min(Math.max(view.scale * factor, this.fitted().scale / 4), 64 / finest);
        const k = 1 / view.scale - 1 / scale;
        this.views[this.axis] = { x: view.x + dx * k, y: view.y - dy * k, scale };
        this.update();
    }

    pan(dx, dy) {
        const view = this.view;
        this.views[this.axis] = { x: view.x - dx / view.scale, y: view.y + dy / view.scale, scale: view.scale };
        this.update();
    }

    /** Something changed: draw what there is, fetch what is missing. */
    update() {
        if (!this.model.print() || this.canvas.hidden) return;
        this.draw();
        this.load();
        this.events.zoomed(this.view.scale);
        this.events.moved();
    }

    wish() {
        const print = this.model.print();
        return {
            generation: this.model.generation(), print: this.model.which, axis: this.axis, at: this.model.at[this.axis],
            colors: this.model.palette(), whole: this.axis === "z" ? 0 : print.whole,
        };
    }

    /** The tiles that cover the canvas, as voxels [from, to) along both axes. */
    visible() {
        const print = this.model.print();
        const view = this.view;
        const half = [this.canvas.clientWidth / 2 / view.scale, this.canvas.clientHeight / 2 / view.scale];
        const centre = [view.x, view.y];
        const ranges = this.axes.map((a, i) => {
            const voxelPixels = view.scale * this.ratio * print.pitch_mm[a];
            const level = Math.max(0, Math.min(12, Math.floor(0.5 - Math.log2(voxelPixels))));
            const step = kTile << level;
            const last = Math.ceil(print.size[a] / step) - 1;
            const from = Math.max(0, Math.floor((centre[i] - half[i]) / print.pitch_mm[a] / step));
            const to = Math.min(last, Math.floor((centre[i] + half[i]) / print.pitch_mm[a] / step));
            return { level, from, to };
        });
        const tiles = [];
        for (let v = ranges[1].from; v <= ranges[1].to; ++v)
            for (let u = ranges[0].from; u <= ranges[0].to; ++u)
                tiles.push({ lu: ranges[0].level, lv: ranges[1].level, u, v });
        return tiles;
    }

    /** Cuts need slices that are far apart in the file: a coarse picture comes first. */
    stages() { return this.axis === "z" ? [1] : [16, 4, 1]; }

    path(plane, tile, coarse) {
        const { whole, ...values } = plane;
        return "api/tile?" + query({ ...values, ...tile, coarse }) + (whole ? `&whole=${whole}` : "");
    }

    async load() {
        if (this.loading) return;
        this.loading = true;
        let key;
        try {
            for (let again = true; again;) {
                again = false;
                const plane = this.wish();
                key = JSON.stringify(plane);
                for (const coarse of this.stages()) {
                    const tiles = this.visible();
                    const finest = tiles.every((t) => this.tiles.has(this.path(plane, t, 1)));
                    if (!finest) await this.fetchAll(plane, tiles, coarse);
                    this.shown = { plane };
                    this.draw();
                    if (JSON.stringify(this.wish()) !== key || JSON.stringify(this.visible()) !== JSON.stringify(tiles)) {
                        again = true;
                        break;
                    }
                    if (finest) break;
                }
            }
            this.events.ready();
        } catch (error) {
            // Of a print that another has replaced while it was asked for; the page knows that one.
            if (error.status === 409 && key !== JSON.stringify(this.wish())) setTimeout(() => this.load());
            else this.events.fail(error);
        } finally {
            this.loading = false;
        }
    }

    async fetchAll(plane, tiles, coarse) {
        const missing = tiles.filter((t) => !this.tiles.has(this.path(plane, t, coarse)));
        const worker = async () => {
            for (let tile; (tile = missing.shift());) {
                const path = this.path(plane, tile, coarse);
                const picture = await getPicture(path);
                this.keep(path, { picture, tile, coarse, plane: JSON.stringify(plane) });
            }
        };
        await Promise.all(Array.from({ length: kAtOnce }, worker));
    }

    keep(path, entry) {
        this.tiles.set(path, entry);
        for (const [key, old] of this.tiles) {
            if (this.tiles.size <= kMostTiles) break;
            old.picture.close();
            this.tiles.delete(key);
        }
    }

    /** Canvas coordinates in CSS pixels of a point of the plane in voxels. */
    toCanvas(u, v) {
        const print = this.model.print();
        const view = this.view;
        return [
            this.canvas.clientWidth / 2 + (u * print.pitch_mm[this.axes[0]] - view.x) * view.scale,
            this.canvas.clientHeight / 2 - (v * print.pitch_mm[this.axes[1]] - view.y) * view.scale,
        ];
    }

    toVoxel(x, y) {
        const print = this.model.print();
        const view = this.view;
        return [
            (view.x + (x - this.canvas.clientWidth / 2) / view.scale) / print.pitch_mm[this.axes[0]],
            (view.y - (y - this.canvas.clientHeight / 2) / view.scale) / print.pitch_mm[this.axes[1]],
        ];
    }

    draw() {
        const print = this.model.print();
        if (!print) return;
        const c = this.context;
        c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
        c.clearRect(0, 0, this.canvas.width, this.canvas.height);
        const style = getComputedStyle(document.body);
        this.drawSheet(c, style);
        // Coarse ones first: what is finer lies over them.
        const plane = this.shown && this.shown.plane.axis === this.axis ? JSON.stringify(this.shown.plane) : "";
        const entries = [...this.tiles.values()].filter((t) => t.plane === plane);
        entries.sort((a, b) => (b.tile.lu + b.tile.lv - a.tile.lu - a.tile.lv) || (b.coarse - a.coarse));
        for (const entry of entries) this.drawTile(c, entry);
        this.drawCrosshair(c, style);
        this.drawMeasured(c, style);
        this.drawScaleBar(c, style);
    }

    drawSheet(c, style) {
        const print = this.model.print();
        const [x0, y1] = this.toCanvas(0, 0);
        const [x1, y0] = this.toCanvas(print.size[this.axes[0]], print.size[this.axes[1]]);
        c.fillStyle = style.getPropertyValue("--sheet");
        c.fillRect(x0, y0, x1 - x0, y1 - y0);
        c.strokeStyle = style.getPropertyValue("--line");
        c.lineWidth = 1;
        c.strokeRect(x0 - 0.5, y0 - 0.5, x1 - x0 + 1, y1 - y0 + 1);
    }

    drawTile(c, { picture, tile, coarse }) {
        const print = this.model.print();
        const u0 = tile.u * (kTile << tile.lu), v0 = tile.v * (kTile << tile.lv);
        const u1 = Math.min(u0 + (kTile << tile.lu), print.size[this.axes[0]]);
        const v1 = Math.min(v0 + (kTile << tile.lv), print.size[this.axes[1]]);
        // A pixel at the far edges may stand for voxels beyond the print: cut it there.
        const w = (u1 - u0) / (1 << tile.lu), h = (v1 - v0) / ((1 << tile.lv) * coarse);
        const [x0, y1] = this.toCanvas(u0, v0);
        const [x1, y0] = this.toCanvas(u1, v1);
        // On whole pixels, or seams show.
        const snap = (value) => Math.round(value * this.ratio) / this.ratio;
        c.imageSmoothingEnabled = (x1 - x0) * this.ratio < w;
        c.drawImage(picture, 0, picture.height - h, w, h, snap(x0), snap(y0), snap(x1) - snap(x0), snap(y1) - snap(y0));
    }

    drawCrosshair(c, style) {
        const picked = this.model.picked;
        if (!picked) return;
        const [a, b] = this.axes;
        const [x, y] = this.toCanvas(picked.voxel[a] + 0.5, picked.voxel[b] + 0.5);
        const here = picked.voxel[axisNames.indexOf(this.axis)] === this.model.at[this.axis];
        c.globalAlpha = here ? 1 : 0.5;
        c.beginPath();
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
            c.moveTo(x + dx * 6, y + dy * 6);
            c.lineTo(x + dx * 16, y + dy * 16);
        }
        const [x0, y1] = this.toCanvas(picked.voxel[a], picked.voxel[b]);
        const [x1, y0] = this.toCanvas(picked.voxel[a] + 1, picked.voxel[b] + 1);
        if (here && x1 - x0 > 4) c.rect(x0, y0, x1 - x0, y1 - y0);
        // Seen on any material.
        for (const [color, width] of [["--panel", 4], ["--accent", 1.5]]) {
            c.strokeStyle = style.getPropertyValue(color);
            c.lineWidth = width;
            c.stroke();
        }
        c.globalAlpha = 1;
    }

    drawMeasured(c, style) {
        const { measure } = this.model;
        const print = this.model.print();
        const places = measure.points.map((mm) => this.toCanvas(...this.axes.map((a) => (mm[a] - print.origin_mm[a]) / print.pitch_mm[a])));
        // Pale where a point is not of this plane.
        const a = axisNames.indexOf(this.axis);
        const here = measure.points.every((mm) => Math.abs(mm[a] - this.depthMm()) <= print.pitch_mm[a] / 2 + 1e-9);
        c.globalAlpha = here ? 1 : 0.5;
        strokeMeasure(c, places, style);
        if (places.length === 2) {
            const [x, y] = [(places[0][0] + places[1][0]) / 2, (places[0][1] + places[1][1]) / 2 - 14];
            c.font = "12px system-ui, sans-serif";
            const width = c.measureText(measure.text).width;
            c.fillStyle = style.getPropertyValue("--panel");
            c.fillRect(x - width / 2 - 4, y - 9, width + 8, 18);
            c.fillStyle = style.getPropertyValue("--text");
            c.textAlign = "center";
            c.textBaseline = "middle";
            c.fillText(measure.text, x, y + 0.5);
            c.textAlign = "start";
            c.textBaseline = "alphabetic";
        }
        c.globalAlpha = 1;
    }

    drawScaleBar(c, style) {
        const length = roundLength(140 / this.view.scale);
        const w = length * this.view.scale;
        const x = 18, y = this.canvas.clientHeight - 18;
        c.globalAlpha = 0.82;
        c.fillStyle = style.getPropertyValue("--panel");
        c.fillRect(8, y - 88, Math.max(w, 44) + 20, 96);
        c.globalAlpha = 1;
        c.fillStyle = style.getPropertyValue("--text");
        c.fillRect(x, y - 3, w, 3);
        c.fillRect(x, y - 8, 1, 8);
        c.fillRect(x + w - 1, y - 8, 1, 8);
        c.font = `12px ${style.fontFamily}`;
        c.fillText(lengthText(length), x + 4, y - 9);
        // Which way is which.
        const [right, up] = this.axes.map((i) => axisNames[i]);
        const y0 = y - 40;
        c.fillRect(x, y0 - 26, 1, 26);
        c.fillRect(x, y0, 26, 1);
        c.fillText(right, x + 29, y0 + 4);
        c.fillText(up, x - 3, y0 - 30);
    }

    listen() {
        const canvas = this.canvas;
        const place = (event) => {
            const box = canvas.getBoundingClientRect();
            return [event.clientX - box.left, event.clientY - box.top];
        };
        let moved = 0, last = null, spread = 0;
        canvas.addEventListener("pointerdown", (event) => {
            canvas.setPointerCapture(event.pointerId);
            this.pointers.set(event.pointerId, place(event));
            if (this.pointers.size === 1) moved = 0;
            last = place(event);
            spread = 0;
        });
        canvas.addEventListener("pointermove", (event) => {
            if (!this.model.print()) return;
            const now = place(event);
            if (this.pointers.has(event.pointerId)) {
                this.pointers.set(event.pointerId, now);
                if (this.pointers.size === 2) {
                    const [p, q] = [...this.pointers.values()];
                    const apart = Math.hypot(p[0] - q[0], p[1] - q[1]);
                    if (spread > 0) this.zoom(apart / spread, (p[0] + q[0]) / 2 - canvas.clientWidth / 2, (p[1] + q[1]) / 2 - canvas.clientHeight / 2);
                    spread = apart;
                } else if (last) {
                    moved += Math.abs(now[0] - last[0]) + Math.abs(now[1] - last[1]);
                    if (moved > 3) this.pan(now[0] - last[0], now[1] - last[1]);
                    last = now;
                }
            }
            this.hoverAt(...now);
        });
        const release = (event) => {
            const single = this.pointers.size === 1;
            this.pointers.delete(event.pointerId);
            if (single && moved <= 3 && event.type === "pointerup" && event.button === 0) this.choose(...place(event));
            last = null;
        };
        canvas.addEventListener("pointerup", release);
        canvas.addEventListener("pointercancel", release);
        canvas.addEventListener("pointerleave", () => this.events.hover(""));
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            if (!this.model.print()) return;
            const [x, y] = place(event);
            if (event.shiftKey) this.events.step(Math.sign(event.deltaY || event.deltaX) * -1);
            else this.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)), x - canvas.clientWidth / 2, y - canvas.clientHeight / 2);
        }, { passive: false });
    }

    /** The voxel under a point of the canvas, or null beside the print. */
    voxelAt(x, y) {
        const print = this.model.print();
        const place = this.toVoxel(x, y).map(Math.floor);
        const voxel = [0, 0, 0];
        voxel[axisNames.indexOf(this.axis)] = this.model.at[this.axis];
        for (let i = 0; i < 2; ++i) {
            if (place[i] < 0 || place[i] >= print.size[this.axes[i]]) return null;
            voxel[this.axes[i]] = place[i];
        }
        return voxel;
    }

    /** Where the plane lies along its axis. */
    depthMm() {
        const print = this.model.print();
        const a = axisNames.indexOf(this.axis);
        return print.origin_mm[a] + (this.model.at[this.axis] + 0.5) * print.pitch_mm[a];
    }

    /** Picks what is at a point of the canvas, or measures from there. */
    choose(x, y) {
        const voxel = this.voxelAt(x, y);
        if (!voxel) return;
        if (!this.model.measure.on) return this.events.pick(voxel);
        const print = this.model.print();
        const place = this.toVoxel(x, y);
        const mm = [0, 0, 0];
        mm[axisNames.indexOf(this.axis)] = this.depthMm();
        this.axes.forEach((a, i) => { mm[a] = print.origin_mm[a] + place[i] * print.pitch_mm[a]; });
        this.events.measure(mm);
    }

    hoverAt(x, y) {
        const voxel = this.voxelAt(x, y);
        const print = this.model.print();
        this.events.hover(!voxel ? "" : voxel.map((v, a) => `${axisNames[a]} ${millimetres(print.origin_mm[a] + (v + 0.5) * print.pitch_mm[a])}`).join("   "));
    }

    /** A step of the keyboard's cursor: a voxel where it is seen, else about so many CSS pixels. */
    gridStep(pixels) {
        return this.axes.map((a) => {
            const voxel = this.view.scale * this.model.print().pitch_mm[a];
            return voxel >= 4 ? voxel : Math.max(1, Math.round(pixels / voxel)) * voxel;
        });
    }
}

// The print as a volume: rays through a texture of cells, which the server fills coarse to fine. Orthographic, lit from
// the upper left. While it turns, it is drawn at the resolution that keeps up.

import { getBytes, query } from "./api.js";
import { Camera } from "./camera.js";
import { axisNames, millimetres } from "./format.js";
import { firstHit, kFragment, kVertex } from "./rays.js";
import { axesOf, Scene } from "./scene.js";

/** CSS pixels about a tip of the axes, or a drag that is still a click. */
const kTip = 10;
const kClick = 4;
/** Of the first picture, which nobody has waited for a sharper one of. */
const kFirstCoarse = 3;
const kMostMs = 250;

export class VolumeView {
    /** `model` has print(), palette(), which, at, picked and measure; `events` has pick, measure, hover, zoomed, moved, notice, fail. */
    constructor(canvas, below, above, model, events) {
        this.canvas = canvas;
        this.model = model;
        this.events = events;
        this.camera = new Camera();
        this.scene = new Scene(below, above);
        this.clip = [false, false, false];
        this.coarseness = 1;
        this.have = "";
        this.step = 0;
        this.bytes = null;
        this.waiting = false;
        this.listen();
        new ResizeObserver(() => this.draw()).observe(canvas);
    }

    static canDraw() { return document.createElement("canvas").getContext("webgl2") !== null; }

    start() {
        if (this.gl) return;
        const gl = this.gl = this.canvas.getContext("webgl2", { premultipliedAlpha: true, antialias: false, preserveDrawingBuffer: true });
        if (!gl) throw new Error("this browser offers no WebGL2, which the 3-D view needs");
        this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
        this.canvas.addEventListener("webglcontextrestored", () => { this.gl = null; this.have = ""; this.start(); this.update(); });
        const program = gl.createProgram();
        for (const [kind, text] of [[gl.VERTEX_SHADER, kVertex], [gl.FRAGMENT_SHADER, kFragment]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, text);
            gl.compileShader(shader);
            if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
        gl.useProgram(program);
        this.place = (name) => gl.getUniformLocation(program, name);
        gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
        for (const [name, value] of [["MIN_FILTER", "LINEAR_MIPMAP_NEAREST"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"], ["WRAP_R", "CLAMP_TO_EDGE"]])
            gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_${name}`], gl[value]);
    }

    wish() { return { generation: this.model.generation(), print: this.model.which, colors: this.model.palette() }; }

    steps() { return this.model.which === "diff" ? this.model.state.difference_steps : this.model.print().volume.steps; }

    /** Fetches what is new of the volume, and again while the server goes on with it. */
    async update() {
        if (this.canvas.hidden || !this.model.print()) return;
        this.draw();
        if (this.waiting) return;
        this.waiting = true;
        let key;
        try {
            this.start();
            for (;;) {
                key = query(this.wish());
                const got = await getBytes(`api/volume?${key}&known=${key === this.have ? this.step : 0}`);
                const { cells } = this.model.print().volume;
                if (got && got.bytes.length === cells[0] * cells[1] * cells[2] * 4) {
                    const gl = this.gl;
                    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
                    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA8, cells[0], cells[1], cells[2], 0, gl.RGBA, gl.UNSIGNED_BYTE, got.bytes);
                    gl.generateMipmap(gl.TEXTURE_3D);
                    this.bytes = got.bytes;
                    this.have = key;
                    this.step = got.step;
                    this.drawSoon(this.first ? this.coarseness : kFirstCoarse);
                    this.first = true;
                }
                if (this.canvas.hidden) break;
                this.events.notice(this.step === 0 ? "reading the print …" : "");
                if (this.step >= this.steps() && this.have === query(this.wish())) break;
                await new Promise((done) => setTimeout(done, got ? 150 : 300));
                if (this.canvas.hidden) break;
            }
        } catch (error) {
            // Of a print that another has replaced while it was asked for; the page knows that one.
            if (error.status === 409 && key !== query(this.wish())) setTimeout(() => this.update());
            else this.events.fail(error);
        } finally {
            this.waiting = false;
        }
    }

    sizeMm() {
        const print = this.model.print();
        return print.size.map((n, a) => n * print.pitch_mm[a]);
    }

    look() { return this.camera.look(this.sizeMm(), this.canvas.clientWidth, this.canvas.clientHeight); }

    /** A place of the build in mm from the middle of the box, and back. */
    fromMiddle(mm) {
        const { origin_mm } = this.model.print();
        return mm.map((v, a) => v - origin_mm[a] - this.sizeMm()[a] / 2);
    }

    toBuild(point) {
        const { origin_mm } = this.model.print();
        return point.map((v, a) => v + origin_mm[a] + this.sizeMm()[a] / 2);
    }

    /** What the cuts leave of the box: what lies towards the viewer goes, or above. */
    box(look) {
        const print = this.model.print();
        const size = this.sizeMm();
        const low = size.map((s) => -s / 2), high = size.map((s) => s / 2);
        axisNames.forEach((axis, a) => {
            if (!this.clip[a]) return;
            const place = (this.model.at[axis] + 1) * print.pitch_mm[a] - size[a] / 2;
            if (a === 2 ? this.camera.tilt >= 0 : look.towards[a] > 0) high[a] = place; else low[a] = place - print.pitch_mm[a];
        });
        return { size, low, high };
    }

    stepMm(size) {
        const { cells } = this.model.print().volume;
        return Math.max(Math.min(...size.map((s, a) => s / cells[a])) * 0.6, Math.hypot(...size) / 900);
    }

    draw(coarse = Math.max(this.coarseness, this.sharpest())) {
        if (this.canvas.hidden || !this.gl || this.step === 0 || !this.model.print() || this.asked) {
            if (this.asked) this.asked = coarse;
            return;
        }
        this.asked = coarse;
        requestAnimationFrame(() => {
            const scale = this.asked;
            this.asked = 0;
            if (!this.canvas.hidden && this.canvas.clientWidth > 0) this.drawNow(scale);
        });
    }

    drawNow(coarse) {
        const gl = this.gl;
        const ratio = (devicePixelRatio || 1) / coarse;
        const w = Math.max(1, Math.round(this.canvas.clientWidth * ratio)), h = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
        if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
        gl.viewport(0, 0, w, h);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT);
        const look = this.look();
        const { size, low, high } = this.box(look);
        const set = (name, values) => gl[`uniform${values.length}f`](this.place(name), ...values);
        set("size_mm", size); set("right", look.right); set("up", look.up); set("towards", look.towards.map((v) => v || 1e-6));
        set("low", low); set("high", high); set("cell_mm", size.map((s, a) => s / this.model.print().volume.cells[a])); set("step_mm", [this.stepMm(size)]);
        set("half_mm", [look.width / 2 / look.scale, look.height / 2 / look.scale]);
        set("middle_mm", look.middle); set("pixels", [w, h]);
        const begin = performance.now();
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        // Waits for the picture: where it is drawn without a graphics processor it may take seconds.
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        this.msPerPixel = (performance.now() - begin) / (w * h);
        const { picked, measure } = this.model;
        this.scene.draw(look, {
            size, low, high, cuts: this.clip, picked: picked && this.fromMiddle(picked.mm),
            measured: measure.points.map((point) => this.fromMiddle(point)), measuredText: measure.text,
        });
        this.events.zoomed(look.scale);
    }

    /** Draws while something moves; the next frame takes the size that this one's time suggests. */
    move() {
        const now = performance.now();
        if (this.last && now - this.last < 400) {
            const took = now - this.last;
            if (took > 45) this.coarseness = Math.min(4, this.coarseness * 1.3);
            else if (took < 20) this.coarseness = Math.max(1, this.coarseness / 1.1);
        }
        this.last = now;
        this.drawSoon(this.coarseness);
        this.events.moved();
    }

    /** Draws at once as coarse as that, and sharp when nothing else comes. */
    drawSoon(coarse) {
        this.draw(coarse);
        clearTimeout(this.settle);
        this.settle = setTimeout(() => this.draw(this.sharpest()), 180);
    }

    /** As sharp as a picture of a quarter of a second goes. */
    sharpest() {
        const pixels = this.canvas.clientWidth * this.canvas.clientHeight * (devicePixelRatio || 1) ** 2;
        return Math.min(Math.max(1, Math.sqrt((this.msPerPixel ?? 0) * pixels / kMostMs)), 6);
    }

    turnBy(dx, dy) {
        this.camera.turnBy(dx * 0.008, dy * 0.008);
        this.move();
    }

    pan(dx, dy) {
        const { scale } = this.look();
        this.camera.middle = [this.camera.middle[0] + dx / scale, this.camera.middle[1] - dy / scale];
        this.move();
    }

    /** Zooms about a point of the canvas, in CSS pixels from its middle. */
    zoom(factor, dx = 0, dy = 0) {
        const before = this.look().scale;
        this.camera.zoom(factor);
        const k = 1 / this.look().scale - 1 / before;
        this.camera.middle = [this.camera.middle[0] + dx * k, this.camera.middle[1] - dy * k];
        this.move();
    }

    fit() {
        this.camera.fit();
        this.move();
    }

    stand(name) {
        this.camera.stand(name);
        this.move();
    }

    // What is pointed at.

    /** The place in the build that is seen at a point of the canvas, or null. */
    placeAt(x, y) {
        if (!this.bytes) return null;
        const look = this.look();
        const { size, low, high } = this.box(look);
        const hit = firstHit({
            bytes: this.bytes, cells: this.model.print().volume.cells, size, low, high,
            from: look.fromCanvas(x, y), way: look.towards.map((v) => -v), step: this.stepMm(size) / 2,
        });
        return hit && this.toBuild(hit);
    }

    choose(x, y) {
        const { middle, tips } = axesOf(this.look());
        const tip = tips.findLast((one) => Math.hypot(x - one.place[0], y - one.place[1]) <= kTip);
        if (tip) return this.stand(tip.stand);
        if (Math.hypot(x - middle[0], y - middle[1]) <= kTip) return this.stand("iso");
        const mm = this.placeAt(x, y);
        if (!mm) return;
        if (this.model.measure.on) return this.events.measure(mm);
        const print = this.model.print();
        const voxel = mm.map((v, a) => Math.min(Math.max(Math.floor((v - print.origin_mm[a]) / print.pitch_mm[a]), 0), print.size[a] - 1));
        // A cell that is partly solid stands for all of its voxels.
        const reach = Math.ceil(Math.max(...[0, 1].map((a) => print.size[a] / print.volume.cells[a])));
        this.events.pick(voxel, Math.min(reach, 64));
    }

    hoverAt(x, y) {
        const mm = this.placeAt(x, y);
        this.events.hover(mm ? mm.map((v, a) => `${axisNames[a]} ${millimetres(v)}`).join("   ") : "");
    }

    gridStep(pixels) { return [pixels, pixels]; }

    listen() {
        let last = null, moved = 0;
        const canvas = this.canvas;
        const place = (event) => {
            const box = canvas.getBoundingClientRect();
            return [event.clientX - box.left, event.clientY - box.top];
        };
        const pointers = new Map();
        let spread = 0;
        canvas.addEventListener("pointerdown", (event) => {
            canvas.setPointerCapture(event.pointerId);
            pointers.set(event.pointerId, place(event));
            if (pointers.size === 1) moved = 0;
            last = place(event);
            spread = 0;
        });
        canvas.addEventListener("pointermove", (event) => {
            if (!this.model.print()) return;
            const now = place(event);
            if (!last) return this.hoverAt(...now);
            const dx = now[0] - last[0], dy = now[1] - last[1];
            if (pointers.has(event.pointerId)) pointers.set(event.pointerId, now);
            if (pointers.size === 2) {
                const [p, q] = [...pointers.values()];
                const apart = Math.hypot(p[0] - q[0], p[1] - q[1]);
                if (spread > 0) this.zoom(apart / spread, (p[0] + q[0]) / 2 - canvas.clientWidth / 2, (p[1] + q[1]) / 2 - canvas.clientHeight / 2);
                spread = apart;
                moved = Infinity;
            } else {
                moved += Math.abs(dx) + Math.abs(dy);
                if (moved > kClick && (event.shiftKey || event.buttons & 6)) this.pan(dx, dy);
                else if (moved > kClick) this.turnBy(dx, dy);
            }
            last = now;
        });
        const release = (event) => {
            pointers.delete(event.pointerId);
            if (last && moved <= kClick && event.type === "pointerup" && event.button === 0 && this.model.print()) this.choose(...place(event));
            last = null;
        };
        canvas.addEventListener("pointerup", release);
        canvas.addEventListener("pointercancel", release);
        canvas.addEventListener("pointerleave", () => this.events.hover(""));
        canvas.addEventListener("contextmenu", (event) => event.preventDefault());
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            if (!this.model.print()) return;
            const [x, y] = place(event);
            if (event.shiftKey) this.events.step(Math.sign(event.deltaY || event.deltaX) * -1);
            else this.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)), x - canvas.clientWidth / 2, y - canvas.clientHeight / 2);
        }, { passive: false });
    }
}

// The print as a volume: rays through a texture of cells, which the server fills coarse to fine. Orthographic, lit from
// the upper left. While it turns, it is drawn at the resolution that keeps up.

import { getBytes, query } from "./api.js";
import { lengthText, roundLength } from "./format.js";

const kVertex = `#version 300 es
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
    gl_Position = vec4(corner, 0.0, 1.0);
}`;

// Alpha of a cell is how much a millimetre hides: s = a / (1 - a) per mm, as in the previews' model view.
const kFragment = `#version 300 es
precision highp float;
precision highp sampler3D;
uniform sampler3D cells;
uniform vec3 size_mm, right, up, towards, low, high;
uniform vec2 half_mm, pixels, middle_mm;
uniform float step_mm;
uniform vec3 cell_mm;
out vec4 result;
vec4 at(vec3 p) { return texture(cells, p / size_mm + 0.5); }
void main() {
    vec2 screen = (gl_FragCoord.xy / pixels * 2.0 - 1.0) * half_mm - middle_mm;
    vec3 from = right * screen.x + up * screen.y;
    vec3 way = -towards;
    vec3 a = (low - from) / way, b = (high - from) / way;
    vec3 near3 = min(a, b), far3 = max(a, b);
    float t0 = max(max(near3.x, near3.y), near3.z), t1 = min(min(far3.x, far3.y), far3.z);
    result = vec4(0.0);
    if (t0 >= t1) return;
    vec3 light = normalize(towards * 0.7 + up * 0.6 - right * 0.45);
    float shift = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    vec3 color = vec3(0.0);
    float through = 1.0;
    bool first = true;
    float step_now = step_mm;
    for (float t = t0 + step_mm * 0.5 * shift; t < t1 && through > 0.01; t += step_now) {
        vec3 p = from + way * t;
        vec4 cell = at(p);
        if (cell.a < 0.004) { first = false; continue; }
        float strength = cell.a > 0.98 ? 60.0 / step_mm : cell.a / (1.0 - cell.a) + (cell.a > 0.5 ? (cell.a - 0.5) * 8.0 / step_mm : 0.0);
        float hidden = 1.0 - exp(-strength * step_mm);
        float lit = 0.95;  // a cut face shows its colours
        if (!first || cell.a < 0.6) {
            vec3 d = cell_mm * 1.2;
            vec3 normal = -vec3(at(p + vec3(d.x, 0, 0)).a - at(p - vec3(d.x, 0, 0)).a,
                           at(p + vec3(0, d.y, 0)).a - at(p - vec3(0, d.y, 0)).a,
                           at(p + vec3(0, 0, d.z)).a - at(p - vec3(0, 0, d.z)).a) / d;
            float length2 = dot(normal, normal);
            normal = length2 > 1e-8 ? normal * inversesqrt(length2) : towards;
            lit = 0.42 + 0.5 * max(dot(normal, light), 0.0) + 0.12 * max(dot(normal, towards), 0.0);
        }
        first = false;
        color += through * hidden * min(cell.rgb * lit, vec3(1.0));
        through *= 1.0 - hidden;
    }
    result = vec4(color, 1.0 - through);
}`;

export class VolumeView {
    constructor(canvas, model, events) {
        this.canvas = canvas;
        this.model = model;
        this.events = events;
        this.turn = 0.55;
        this.tilt = 0.5;
        this.magnified = 1;
        this.middle = [0, 0];
        this.clip = [false, false, false];
        this.coarseness = 1;
        this.have = "";
        this.step = 0;
        this.waiting = false;
        this.listen();
        new ResizeObserver(() => this.draw()).observe(canvas);
    }

    start() {
        if (this.gl) return;
        const gl = this.gl = this.canvas.getContext("webgl2", { premultipliedAlpha: true, antialias: false, preserveDrawingBuffer: true });
        if (!gl) throw new Error("this browser offers no WebGL2, which the 3-D view needs");
        this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
        this.canvas.addEventListener("webglcontextrestored", () => { this.gl = null; this.have = ""; this.start(); this.update(); });
        const program = this.program = gl.createProgram();
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
        this.texture = gl.createTexture();
        gl.bindTexture(gl.TEXTURE_3D, this.texture);
        for (const [name, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"], ["WRAP_T", "CLAMP_TO_EDGE"], ["WRAP_R", "CLAMP_TO_EDGE"]])
            gl.texParameteri(gl.TEXTURE_3D, gl[`TEXTURE_${name}`], gl[value]);
    }

    /** Fetches what is new of the volume, and again while the server goes on with it. */
    async update() {
        if (this.canvas.hidden || !this.model.print()) return;
        this.draw();
        if (this.waiting) return;
        this.waiting = true;
        try {
            this.start();
            for (;;) {
                const values = { generation: this.model.generation(), print: this.model.which === "1" ? 1 : 0, colors: this.model.palette() };
                const key = query(values);
                const got = await getBytes(`api/volume?${key}&known=${key === this.have ? this.step : 0}`);
                const { cells, steps } = this.model.print().volume;
                if (got && got.bytes.length === cells[0] * cells[1] * cells[2] * 4) {
                    const gl = this.gl;
                    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
                    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA8, cells[0], cells[1], cells[2], 0, gl.RGBA, gl.UNSIGNED_BYTE, got.bytes);
                    this.have = key;
                    this.step = got.step;
                    this.draw();
                }
                this.events.notice(this.step === 0 ? "reading the print …" : "");
                if (this.canvas.hidden || (this.step >= steps && this.have === query({ ...values, colors: this.model.palette() }))) break;
                await new Promise((done) => setTimeout(done, got ? 150 : 300));
                if (this.canvas.hidden) break;
            }
        } catch (error) {
            this.events.fail(error);
        } finally {
            this.waiting = false;
        }
    }

    sizeMm() {
        const print = this.model.print();
        return print.size.map((n, a) => n * print.pitch_mm[a]);
    }

    /** CSS pixels a mm. */
    scale() {
        const size = this.sizeMm();
        // All of it, however it is turned, as long as it is not tilted by more than 45 degrees.
        const across = Math.hypot(size[0], size[1]);
        const high = (across + size[2]) * Math.SQRT1_2;
        return this.magnified * 0.94 * Math.min(this.canvas.clientWidth / across, this.canvas.clientHeight / high);
    }

    axesOfView() {
        const [ct, st, ce, se] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
        return { right: [ct, st, 0], up: [-st * se, ct * se, ce], towards: [st * ce, -ct * ce, se] };
    }

    draw(coarse = this.coarseness) {
        if (this.canvas.hidden || !this.gl || this.step === 0 || !this.model.print() || this.asked) {
            if (this.asked) this.asked = coarse;
            return;
        }
        this.asked = coarse;
        requestAnimationFrame(() => {
            const scale = this.asked;
            this.asked = 0;
            this.drawNow(scale);
        });
    }

    drawNow(coarse) {
        const gl = this.gl;
        const print = this.model.print();
        const ratio = (devicePixelRatio || 1) / coarse;
        const w = Math.max(1, Math.round(this.canvas.clientWidth * ratio)), h = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
        if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
        gl.viewport(0, 0, w, h);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT);
        const size = this.sizeMm();
        const scale = this.scale();
        const { right, up, towards } = this.axesOfView();
        const low = size.map((s) => -s / 2), high = size.map((s) => s / 2);
        ["x", "y", "z"].forEach((axis, a) => {
            if (!this.clip[a]) return;
            // What lies towards the viewer goes, or above.
            const place = (this.model.at[axis] + 1) * print.pitch_mm[a] - size[a] / 2;
            if (a === 2 ? this.tilt >= 0 : towards[a] > 0) high[a] = place; else low[a] = place - print.pitch_mm[a];
        });
        const cell = size.map((s, a) => s / print.volume.cells[a]);
        const step = Math.max(Math.min(...cell) * 0.6, Math.hypot(...size) / 900);
        const set = (name, values) => gl[`uniform${values.length}f`](this.place(name), ...values);
        set("size_mm", size); set("right", right); set("up", up); set("towards", towards.map((v) => v || 1e-6));
        set("low", low); set("high", high); set("cell_mm", cell); set("step_mm", [step]);
        set("half_mm", [this.canvas.clientWidth / 2 / scale, this.canvas.clientHeight / 2 / scale]);
        set("middle_mm", this.middle); set("pixels", [w, h]);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        this.events.zoomed(scale);
        this.events.scaleBar(lengthText(roundLength(140 / scale)), roundLength(140 / scale) * scale);
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
        this.draw(this.coarseness);
        clearTimeout(this.settle);
        this.settle = setTimeout(() => this.draw(1), 180);
    }

    turnBy(dx, dy) {
        this.turn -= dx * 0.008;
        this.tilt = Math.min(Math.max(this.tilt + dy * 0.008, -1.57), 1.57);
        this.move();
    }

    zoom(factor) {
        this.magnified = Math.min(Math.max(this.magnified * factor, 0.3), 40);
        this.move();
    }

    fit() {
        this.magnified = 1;
        this.middle = [0, 0];
        this.move();
    }

    listen() {
        let last = null;
        const canvas = this.canvas;
        canvas.addEventListener("pointerdown", (event) => {
            canvas.setPointerCapture(event.pointerId);
            last = [event.clientX, event.clientY];
        });
        canvas.addEventListener("pointermove", (event) => {
            if (!last) return;
            const dx = event.clientX - last[0], dy = event.clientY - last[1];
            last = [event.clientX, event.clientY];
            if (event.shiftKey || event.buttons & 4) {
                this.middle = [this.middle[0] + dx / this.scale(), this.middle[1] - dy / this.scale()];
                this.move();
            } else this.turnBy(dx, dy);
        });
        for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { last = null; });
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            this.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)));
        }, { passive: false });
    }
}

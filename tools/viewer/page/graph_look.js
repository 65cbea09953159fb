// What nodes are: a picture of each over the slice that is shown, over the surface, or a curve along a line, and its value
// in the voxel that was picked. The compiled fablet is run for them, once for all nodes in view.

import { textureUrl } from "./textures.js";

const kSoonMs = 250, kMost = 48;
const kPlain = /^(float|int|uint|bool)[234]?$/;

/** Whether a node has values that can be shown. Those of uniforms are the same everywhere. */
export function canBeLookedAt(node) {
    const type = node.kind === "result" ? node.ports[0]?.type : node.outputs[0]?.type;
    return Boolean(type) && (kPlain.test(type) || type === "MaterialComposition");
}

export function hasPicture(node) {
    return canBeLookedAt(node) && node.role !== "uniform" && node.role !== "constant";
}

export function isTexture(node) {
    return node.role === "uniform" && /^ImageTexture[23]D$/.test(node.outputs[0]?.type ?? "");
}

/** The lines of a curve in a box of `width` by `height`, one for each number: paths with gaps where there is none. */
export function curvePaths({ values, numbers, low, high }, width, height) {
    const count = values.length / numbers;
    const range = high > low ? high - low : 1;
    return Array.from({ length: numbers }, (_, c) => {
        let path = "";
        let pen = false;
        for (let i = 0; i < count; ++i) {
            const v = values[i * numbers + c];
            if (v !== null) path += `${pen ? "L" : "M"}${(i / Math.max(count - 1, 1) * width).toFixed(1)} ${(height - (high > low ? (v - low) / range : 0.5) * height).toFixed(1)}`;
            pen = v !== null;
        }
        return path;
    });
}

/** Four digits of a number, as short as that goes; the server writes what is none as text. */
export function short(v) {
    return typeof v === "number" ? String(Number(v.toPrecision(4))) : v;
}

/** Million voxels a second, to three digits. */
export function speedText(m) {
    return m < 1 ? `${Number((1000 * m).toPrecision(3))} k` : `${Number(m.toPrecision(3))} M`;
}

const kComponents = { x: 0, y: 1, z: 2, w: 3, r: 0, g: 1, b: 2, a: 3 };

/** The numbers of a value behind `.xy`. */
export function membersOf(values, suffix) {
    const letters = /^\.([xyzwrgba]{1,4})$/.exec(suffix ?? "")?.[1];
    return letters ? [...letters].map((one) => values[kComponents[one]]) : values;
}

export class GraphLooks {
    /**
     * `ask` sends a request, `show` draws what came, `tell` says why nothing does, `colorOf` is that of a material's
     * uniform, `boundTo` the name of a texture's.
     */
    constructor({ ask, show, tell, colorOf, boundTo }) {
        Object.assign(this, { ask, show, tell, colorOf, boundTo });
        this.isOn = true;
        this.over = "slice";   // slice, surface, or x, y, z: along that axis
        this.plane = null;     // {axis, point_mm} of the view
        this.point = null;
        this.textures = new Map();
        this.forget();
    }

    forget() {
        this.pictures = new Map();  // by the key of a node: {url or curve, low, high, type}
        this.values = new Map();    // likewise: numbers, of a mixture by uniform
    }

    /** What is drawn: {text, tab, name, stage, nodes: [{id, key, picture}]}. */
    want(drawn) {
        this.drawn = drawn;
        this.soon();
    }

    setOver(over) {
        this.over = over;
        this.soon();
    }

    /** The plane of voxels that the page shows, by the axis across it and a point in it. */
    setPlane(plane) {
        if (JSON.stringify(plane) === JSON.stringify(this.plane)) return;
        this.plane = plane;
        this.soon();
    }

    setPoint(mm) {
        this.point = mm;
        this.values = new Map();
        this.soon();
    }

    /** Where pictures are taken, as the server wants it. Points of a surface are on it; a function is seen over slices alone. */
    placeOf(drawn) {
        if (!drawn.stage) return { over: "slice", axis: 2, point_mm: this.plane.point_mm };
        if (drawn.name === "@Surface" || this.over === "surface") return { over: "surface" };
        const axis = ["x", "y", "z"].indexOf(this.over);
        if (axis >= 0) return { over: "line", axis, point_mm: this.point ?? this.plane.point_mm };
        return { over: "slice", ...this.plane };
    }

    /** A print has the processor first. */
    setBusy(busy) {
        const was = this.busy;
        this.busy = busy;
        if (was && !busy) this.soon();
    }

    soon() {
        clearTimeout(this.timer);
        this.timer = setTimeout(() => this.work(), kSoonMs);
    }

    async work() {
        if (!this.isOn || !this.drawn || this.busy || this.working || !this.plane) return;
        this.working = true;
        try {
            while (this.isOn && this.drawn && !this.busy) {
                const { drawn, point } = this;
                const place = JSON.stringify(this.placeOf(drawn));
                if (this.done?.drawn !== drawn || this.done.place !== place) await this.takePictures(drawn, place);
                if (point && (this.pointDone?.drawn !== drawn || this.pointDone.point !== point)) await this.takeValues(drawn, point);
                if (this.drawn === drawn && this.point === point && JSON.stringify(this.placeOf(drawn)) === place) break;
            }
            this.tell("");
        } catch (error) {
            this.done = { drawn: this.drawn, place: JSON.stringify(this.placeOf(this.drawn)) };
            this.pointDone = { drawn: this.drawn, point: this.point };
            this.tell(error.message);
        }
        this.working = false;
    }

    actionOf(drawn, nodes) {
        return { tab: drawn.tab, nodes: nodes.map((node) => node.id) };
    }

    async takePictures(drawn, place) {
        const wanted = drawn.nodes.filter((node) => node.picture).slice(0, kMost);
        const got = wanted.length ? await this.ask(drawn.text, { ...this.actionOf(drawn, wanted), ...JSON.parse(place) }) : { nodes: [] };
        this.done = { drawn, place };
        if (drawn !== this.drawn) return;
        const painted = await Promise.all(got.nodes.map(async (one) => {
            const { low, high, type } = one;
            const made = got.axis === undefined ? { url: await this.paint(got, one) } : { curve: this.curveOf(got, one) };
            return [drawn.nodes.find((node) => node.id === one.node).key, { ...made, low, high, type }];
        }));
        const before = this.pictures;
        this.pictures = new Map(painted);
        this.show();
        for (const { url } of before.values()) if (url) URL.revokeObjectURL(url);
    }

    async takeValues(drawn, point) {
        if (drawn.name === "@Surface") return void (this.pointDone = { drawn, point });
        const wanted = drawn.nodes.slice(0, kMost);
        const got = wanted.length ? await this.ask(drawn.text, { ...this.actionOf(drawn, wanted), over: "voxel", point_mm: point }) : { nodes: [] };
        this.pointDone = { drawn, point };
        if (drawn !== this.drawn || point !== this.point) return;
        this.values = new Map(got.nodes.map((one) => [drawn.nodes.find((node) => node.id === one.node).key, one.values]));
        this.show();
    }

    /** What a texture's node shows, once it is there; the URL is that of the page's other pictures of it. */
    textureOf(node) {
        const name = this.boundTo(node.title);
        if (!name) return undefined;
        const asked = textureUrl(name, node.outputs[0].type.endsWith("3D"));
        if (this.textures.get(name)?.asked !== asked) {
            this.textures.set(name, { asked });
            asked.then((url) => { if (url) { this.textures.set(name, { asked, url }); this.show(); } });
        }
        const { url } = this.textures.get(name);
        return url ? { url, name } : undefined;
    }

    /** A curve: values with the colours of their lines, mixtures' in those of their materials. */
    curveOf({ axis, from_mm, step_mm, materials }, { type, numbers, values, low, high }) {
        const colors = type === "MaterialComposition" ? materials.map((name) => `rgb(${this.colorOf(name).join(" ")})`)
            : numbers === 1 ? ["var(--accent)"] : ["var(--axis_x)", "var(--axis_y)", "var(--axis_z)", "var(--measure)"];
        const limits = type === "MaterialComposition" ? { low: 0, high: 1 } : { low, high };
        return { axis, from_mm, step_mm, numbers, values, colors, ...limits };
    }

    /** Numbers as greys or colours, mixtures in the colours of their materials. */
    async paint({ width, height, inside, materials }, { type, numbers, values }) {
        const canvas = new OffscreenCanvas(width, height);
        const image = new ImageData(width, height);
        const colors = type === "MaterialComposition" ? materials.map((name) => this.colorOf(name)) : null;
        for (let i = 0; i < width * height; ++i) {
            if (!inside[i]) continue;
            const own = values.slice(i * numbers, (i + 1) * numbers);
            image.data.set([...this.colorAt(own, colors), 255], 4 * i);
        }
        canvas.getContext("2d").putImageData(image, 0, 0);
        return URL.createObjectURL(await canvas.convertToBlob());
    }

    colorAt(own, colors) {
        // What is no number stands out.
        if (own[0] < 0) return [255, 0, 255];
        if (colors) {
            const total = Math.max(255, own.reduce((sum, v) => sum + v, 0));
            return [0, 1, 2].map((c) => own.reduce((sum, v, m) => sum + v * colors[m][c], 0) / total);
        }
        return own.length === 1 ? [own[0], own[0], own[0]] : [own[0], own[1], own[2] ?? 0];
    }
}

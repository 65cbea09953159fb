// What nodes are: a picture of each over the slice that is shown (of @Surface over the surface), and its value in the
// voxel that was picked. The compiled fablet is run for them, once for all nodes in view.

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

/** Four digits of a number, as short as that goes; the server writes what is none as text. */
export function short(v) {
    return typeof v === "number" ? String(Number(v.toPrecision(4))) : v;
}

const kComponents = { x: 0, y: 1, z: 2, w: 3, r: 0, g: 1, b: 2, a: 3 };

/** The numbers of a value behind `.xy`. */
export function membersOf(values, suffix) {
    const letters = /^\.([xyzwrgba]{1,4})$/.exec(suffix ?? "")?.[1];
    return letters ? [...letters].map((one) => values[kComponents[one]]) : values;
}

export class GraphLooks {
    /** `ask` sends a request, `show` draws what came, `tell` says why nothing does, `colorOf` is that of a material's uniform. */
    constructor({ ask, show, tell, colorOf }) {
        Object.assign(this, { ask, show, tell, colorOf });
        this.isOn = true;
        this.slice = 0;
        this.point = null;
        this.forget();
    }

    forget() {
        this.pictures = new Map();  // by the key of a node: {url, low, high, type}
        this.values = new Map();    // likewise: numbers, of a mixture by uniform
    }

    /** What is drawn: {text, tab, name, nodes: [{id, key, picture}]}. */
    want(drawn) {
        this.drawn = drawn;
        this.soon();
    }

    setSlice(slice) {
        if (slice === this.slice) return;
        this.slice = slice;
        this.soon();
    }

    setPoint(mm) {
        this.point = mm;
        this.values = new Map();
        this.pointStale = true;
        this.soon();
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
        if (!this.isOn || !this.drawn || this.busy || this.working) return;
        this.working = true;
        try {
            while (this.isOn && this.drawn && !this.busy) {
                const { drawn, slice, point } = this;
                if (this.done?.drawn !== drawn || this.done.slice !== slice) await this.takePictures(drawn, slice);
                if (point && (this.pointDone?.drawn !== drawn || this.pointDone.point !== point)) await this.takeValues(drawn, point);
                if (this.drawn === drawn && this.slice === slice && this.point === point) break;
            }
            this.tell("");
        } catch (error) {
            this.done = { drawn: this.drawn, slice: this.slice };
            this.pointDone = { drawn: this.drawn, point: this.point };
            this.tell(error.message);
        }
        this.working = false;
    }

    actionOf(drawn, nodes) {
        return { tab: drawn.tab, nodes: nodes.map((node) => node.id), surface: drawn.name === "@Surface" };
    }

    async takePictures(drawn, slice) {
        const wanted = drawn.nodes.filter((node) => node.picture).slice(0, kMost);
        const got = wanted.length ? await this.ask(drawn.text, { ...this.actionOf(drawn, wanted), slice }) : { nodes: [] };
        this.done = { drawn, slice };
        if (drawn !== this.drawn) return;
        const painted = await Promise.all(got.nodes.map(async (one) => [drawn.nodes.find((node) => node.id === one.node).key,
            { url: await this.paint(got, one), low: one.low, high: one.high, type: one.type }]));
        const before = this.pictures;
        this.pictures = new Map(painted);
        this.show();
        for (const { url } of before.values()) URL.revokeObjectURL(url);
    }

    async takeValues(drawn, point) {
        const wanted = drawn.nodes.slice(0, kMost);
        const got = wanted.length ? await this.ask(drawn.text, { ...this.actionOf(drawn, wanted), point_mm: point }) : { nodes: [] };
        this.pointDone = { drawn, point };
        if (drawn !== this.drawn || point !== this.point) return;
        this.values = new Map(got.nodes.map((one) => [drawn.nodes.find((node) => node.id === one.node).key, one.values]));
        this.show();
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

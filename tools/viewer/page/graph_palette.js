// What can be added to a graph: a list that is searched, taken by Enter, a click or a drag.

import { element } from "./format.js";

const byId = (id) => document.getElementById(id);
const kMost = 80;

export class GraphPalette {
    /** `take` gets the entry that was chosen; `picture` asks what one looks like. */
    constructor(take, picture) {
        this.take = take;
        this.pictures = new PictureQueue(picture);
        this.entries = [];
        byId("palette_search").addEventListener("input", () => this.show());
        byId("palette").addEventListener("keydown", (event) => this.key(event));
        byId("palette_close").addEventListener("click", () => this.close());
    }

    get isOpen() { return !byId("palette").hidden; }

    open(entries, wanted) {
        this.entries = entries;
        this.wanted = wanted;  // the type that a wire brings, where one is chosen
        byId("palette_for").textContent = wanted ? `on the wire of a ${wanted}` : "";
        byId("palette").hidden = false;
        byId("palette_search").value = "";
        this.show();
        byId("palette_search").focus();
    }

    close() {
        byId("palette").hidden = true;
    }

    /** Those whose name begins with what is searched for come first, then those that say it anywhere. */
    found() {
        const words = byId("palette_search").value.toLowerCase().split(/\s+/).filter(Boolean);
        const rated = [];
        for (const entry of this.entries) {
            const name = entry.name.toLowerCase();
            const all = `${name} ${entry.module} ${entry.signature} ${entry.help}`.toLowerCase();
            if (!words.every((word) => all.includes(word))) continue;
            if (this.wanted && !entry.parameters.some((p) => mayTake(p.type, this.wanted))) continue;
            const rate = words.length === 0 ? 0 : name === words[0] ? 0 : name.startsWith(words[0]) ? 1 : name.includes(words[0]) ? 2 : entry.module.includes(words[0]) ? 3 : 4;
            rated.push([rate, entry]);
        }
        return rated.sort((a, b) => a[0] - b[0]).map(([, entry]) => entry);
    }

    show() {
        const found = this.found();
        this.pictures.forget();
        byId("palette_list").replaceChildren(...found.slice(0, kMost).map((entry) => this.item(entry)));
        byId("palette_count").textContent = found.length > kMost ? `${found.length} found, the first ${kMost} shown` : `${found.length} found`;
    }

    item(entry) {
        const made = element("button", { class: `entry ${entry.kind}`, draggable: "true", title: entry.help, onclick: () => this.take(entry) },
            this.pictures.of(entry), element("b", {}, entry.name), element("span", { class: "signature" }, entry.signature),
            element("span", { class: "origin" }, [entry.module || entry.kind, entry.ns === undefined ? "" : `${Number(entry.ns.toPrecision(2))} ns`].filter(Boolean).join(" · ")));
        made.addEventListener("dragstart", (event) => {
            event.dataTransfer.setData("text/x-openfl", JSON.stringify({ signature: entry.signature, module: entry.module }));
            event.dataTransfer.effectAllowed = "copy";
        });
        return element("li", {}, made);
    }

    key(event) {
        const items = [...byId("palette_list").querySelectorAll("button")];
        const at = items.indexOf(document.activeElement);
        if (event.key === "Escape") this.close();
        else if (event.key === "Enter" && document.activeElement === byId("palette_search")) items[0]?.click();
        else if (event.key === "ArrowDown") items[Math.min(at + 1, items.length - 1)]?.focus();
        else if (event.key === "ArrowUp") (at > 0 ? items[at - 1] : byId("palette_search")).focus();
        else return;
        event.preventDefault();
        event.stopPropagation();
    }
}

/** Pictures of what is in view, one after the other; each is asked for once. */
class PictureQueue {
    constructor(ask) {
        this.ask = ask;
        this.known = new Map();
        this.wanted = [];
        this.watch = new IntersectionObserver((seen) => {
            for (const { isIntersecting, target } of seen) if (isIntersecting) this.wanted.push(target);
            this.work();
        });
    }

    forget() {
        this.watch.disconnect();
        this.wanted = [];
    }

    of(entry) {
        const canvas = element("canvas", { width: 40, height: 40, "aria-hidden": "true" });
        canvas.entry = entry;
        const key = `${entry.module}/${entry.signature}`;
        if (this.known.has(key)) this.draw(canvas, this.known.get(key));
        else if (entry.kind === "library" || entry.kind === "builtin") this.watch.observe(canvas);
        return canvas;
    }

    async work() {
        if (this.busy) return;
        this.busy = true;
        try {
            while (this.wanted.length) {
                const canvas = this.wanted.shift();
                const { signature, module } = canvas.entry;
                const picture = await this.ask({ signature, module });
                this.known.set(`${module}/${signature}`, picture);
                this.draw(canvas, picture);
            }
        } catch { /* without pictures the list is as good */ }
        this.busy = false;
    }

    draw(canvas, { side, channels, values }) {
        if (!side) return;
        canvas.classList.add("drawn");
        const small = new ImageData(side, side);
        for (let i = 0; i < side * side; ++i) {
            for (let c = 0; c < 3; ++c) small.data[4 * i + c] = values[channels * i + Math.min(c, channels - 1)];
            small.data[4 * i + 3] = 255;
        }
        const sheet = new OffscreenCanvas(side, side);
        sheet.getContext("2d").putImageData(small, 0, 0);
        canvas.getContext("2d").drawImage(sheet, 0, 0, canvas.width, canvas.height);
    }
}

/** Whether a value of a type may go into a parameter, as far as their names tell; the compiler decides. */
export function mayTake(wants, type) {
    if (!wants || !type || wants === type || wants === "T") return true;
    const number = /^(float|int|uint|bool)([234]?)$/;
    const [has, want] = [number.exec(type), number.exec(wants.replace("N", ""))];
    if (!has) return false;
    if (/N$/.test(wants)) return true;
    // A scalar goes with any vector.
    return Boolean(want) && (has[2] === "" || has[2] === want[2]);
}

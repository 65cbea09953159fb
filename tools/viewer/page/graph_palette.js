// What can be added to a graph: categories, and a list that is searched, taken by Enter, a click or a drag. It stands beside
// the graph; in a narrow window above it, and steps aside while one drags.

import { element } from "./format.js";
import { categoryOf, kCategories, plainWords, rate } from "./palette_words.js";
import { oneStop } from "./roving.js";

const byId = (id) => document.getElementById(id);
const kMost = 80;

export class GraphPalette {
    /** `take` gets the entry that was chosen; `picture` asks what one looks like; `moved` hears how far the graph went. */
    constructor(take, picture, moved) {
        Object.assign(this, { take, moved });
        this.pictures = new PictureQueue(picture);
        this.entries = [];
        this.category = null;
        byId("palette_search").addEventListener("input", () => this.show());
        byId("palette_back").addEventListener("click", () => { this.choose(null); byId("palette_search").focus(); });
        byId("palette_list").addEventListener("focusin", (event) => oneStop(this.buttons, event.target));
        byId("palette").addEventListener("keydown", (event) => this.key(event));
        byId("palette_close").addEventListener("click", () => this.close());
    }

    get buttons() { return [...byId("palette_list").querySelectorAll("button")]; }
    get isOpen() { return !byId("palette").hidden; }

    open(entries, wanted) {
        this.entries = entries;
        this.wanted = wanted;  // the type that a wire brings, where one is chosen
        byId("palette_for").textContent = wanted ? `on the wire of a ${wanted}` : "";
        this.setOpen(true);
        byId("palette_search").value = "";
        this.choose(null);
        byId("palette_search").focus();
    }

    close() { this.setOpen(false); }

    /** The graph beside it stays where it is on the screen. */
    setOpen(open) {
        const host = byId("graph_svg");
        const before = host.getBoundingClientRect().left;
        byId("palette").hidden = !open;
        this.moved(before - host.getBoundingClientRect().left);
    }

    choose(category) {
        this.category = category;
        this.show();
    }

    /** Those that fit best come first. */
    found() {
        const words = byId("palette_search").value.toLowerCase().split(/\s+/).filter(Boolean);
        const rated = [];
        for (const entry of this.entries) {
            if (this.wanted && !entry.parameters.some((p) => mayTake(p.type, this.wanted))) continue;
            if (this.category && categoryOf(entry) !== this.category) continue;
            const rated_as = rate(entry, words);
            if (rated_as >= 0) rated.push([rated_as, entry]);
        }
        return rated.sort((a, b) => a[0] - b[0]).map(([, entry]) => entry);
    }

    show() {
        const searched = byId("palette_search").value.trim() !== "";
        const tiles = !searched && !this.category;
        const found = this.found();
        this.pictures.forget();
        const list = byId("palette_list");
        list.classList.toggle("tiles", tiles);
        list.replaceChildren(...(tiles ? this.tiles(found) : found.slice(0, kMost).map((entry, i, all) => this.item(entry, all.filter((one) => one.name === entry.name).length > 1))));
        list.scrollTop = 0;
        oneStop(this.buttons, this.buttons[0]);
        byId("palette_back").hidden = !this.category;
        const count = found.length > kMost ? `${found.length} found, the first ${kMost} shown` : `${found.length} found`;
        byId("palette_count").textContent = tiles ? "choose, or search" : this.category ? `${this.category.name}: ${count}` : count;
        this.tell(null);
    }

    /** A button for each category that has entries. */
    tiles(found) {
        const counts = new Map();
        for (const entry of found) counts.set(categoryOf(entry), (counts.get(categoryOf(entry)) ?? 0) + 1);
        return kCategories.filter((one) => counts.has(one)).map((one) => {
            const shown = this.entries.find((entry) => entry.name === one.shows) ?? found.find((entry) => categoryOf(entry) === one);
            return element("li", {}, element("button", { class: "tile", onclick: () => { this.choose(one); byId("palette_list").querySelector("button")?.focus(); } },
                this.pictures.of(shown), element("b", {}, one.name), element("span", { class: "plain" }, one.about), element("span", { class: "origin" }, String(counts.get(one)))));
        });
    }

    /** Signature, cost and help of the entry that is pointed at, or has the focus. */
    tell(entry) {
        const cost = entry?.ns === undefined ? "" : `${Number(entry.ns.toPrecision(2))} ns a voxel`;
        byId("palette_more").replaceChildren(...(entry ? [element("code", {}, entry.signature), element("span", { class: "origin" }, [entry.module && `module ${entry.module}`, cost].filter(Boolean).join(" · ")),
            element("p", {}, entry.help.replace(/```openfl\n?|```\n?/g, "").trim())] : []));
        byId("palette_more").hidden = !entry;
    }

    /** `of_several` with the same name: then it says what it takes. */
    item(entry, of_several) {
        const made = element("button", { class: `entry ${entry.kind}`, draggable: "true", onclick: () => this.take(entry), onfocus: () => this.tell(entry), onpointerenter: () => this.tell(entry) },
            this.pictures.of(entry), element("b", {}, entry.name), element("span", { class: "origin" }, of_several ? entry.parameters.map((p) => p.type).join(", ") : ""), element("span", { class: "plain" }, plainWords(entry)));
        made.addEventListener("dragstart", (event) => {
            event.dataTransfer.setData("text/x-openfl", JSON.stringify({ signature: entry.signature, module: entry.module }));
            event.dataTransfer.effectAllowed = "copy";
            // Not before the browser has its picture of what is dragged.
            setTimeout(() => document.body.classList.add("dragging_entry"));
        });
        made.addEventListener("dragend", () => document.body.classList.remove("dragging_entry"));
        return element("li", {}, made);
    }

    /** How many stand beside each other. */
    across(items) {
        const top = items[0]?.offsetTop;
        return Math.max(1, items.filter((one) => one.offsetTop === top).length);
    }

    key(event) {
        const items = this.buttons;
        const at = items.indexOf(document.activeElement);
        if (event.key === "Escape" && (this.category || byId("palette_search").value)) {
            byId("palette_search").value = "";
            this.choose(null);
            byId("palette_search").focus();
        } else if (event.key === "Escape") {
            this.close();
            byId("graph_svg").focus();
        }
        else if (event.key === "Enter" && document.activeElement === byId("palette_search")) items[0]?.click();
        else if (event.key === "ArrowDown") items[Math.min(at < 0 ? 0 : at + this.across(items), items.length - 1)]?.focus();
        else if (event.key === "ArrowUp") (at >= this.across(items) ? items[at - this.across(items)] : byId("palette_search")).focus();
        else if (at >= 0 && event.key === "ArrowRight") items[Math.min(at + 1, items.length - 1)].focus();
        else if (at >= 0 && event.key === "ArrowLeft") items[Math.max(at - 1, 0)].focus();
        else if (at >= 0 && event.key.length === 1 && /\S/.test(event.key) && !event.ctrlKey && !event.altKey && !event.metaKey) nextWith(items, at, event.key)?.focus();
        else return;
        event.preventDefault();
        event.stopPropagation();
    }
}

/** The next of `items` whose name begins with a letter, round and round. */
function nextWith(items, at, letter) {
    const begins = (one) => one.querySelector("b").textContent.toLowerCase().startsWith(letter.toLowerCase());
    return [...items.slice(at + 1), ...items.slice(0, at + 1)].find(begins);
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

// The panel "Part": the printer, how large parts are and where, how a mesh is read, materials. Each change is one of the
// world's text, by the server, and can be taken back.

import { getUrl, postJson, query } from "./api.js";
import { element } from "./format.js";
import { kSides, withPicture } from "./part_picture.js";
import { editsOf, kStock, materialFor, scaleFor, swapped, usesOf } from "./part_edits.js";

const byId = (id) => document.getElementById(id);
const kUnits = [["mm", "mm"], ["cm", "cm"], ["m", "m"], ["in", "inch"], ["um", "µm"]];
/** What was chosen stays in its field until the world surely has it: what the page hears before may be older. */
const kHoldMs = 3000;
const printerName = (name) => name.replaceAll("_", " ").replace(/^./, (c) => c.toUpperCase());

export class PartPanel {
    /** `run` does something that asks the server, and shows what comes of it; `editor` holds the fablet's text. */
    constructor(run, editor) {
        Object.assign(this, { run, editor });
        this.picture = { side: "4", width: 20, depth: 0.5 };
        this.shown = "";
        byId("part_undo").addEventListener("click", () => this.run(() => postJson("api/unpart", {})));
        byId("part_redo").addEventListener("click", () => this.run(() => postJson("api/repart", {})));
    }

    /** Makes changes: {path, value}, or without a value what is there is left out. */
    edit(...edits) { return this.run(() => postJson("api/part", { edits })); }

    /** A picture was chosen by a dialog, after which the focus goes to what puts it on. */
    expectPicture() {
        this.expected = "picture_put";  // once the world has it
        this.shown = "";
    }

    show({ part, objects, textures }) {
        const now = JSON.stringify([part, objects.map((one) => [one.name, one.uniforms.map((u) => [u.name, u.value])]), textures]);
        if (now === this.shown) return;
        this.shown = now;
        const focused = this.expected ?? document.activeElement?.dataset?.control;
        const fresh = this.textures && textures.find((one) => !this.textures.includes(one));
        if (fresh) this.picture.texture = fresh;
        this.textures = textures;
        byId("part").replaceChildren(...this.printer(part), ...(part.build ?? []).flatMap((item, i) => this.item(part, item, i)));
        byId("part_materials").replaceChildren(...this.materials(part, objects));
        byId("part_picture").replaceChildren(...this.pictures(part, objects, textures));
        const field = focused && document.querySelector(`#live [data-control="${focused}"]`);
        field?.focus();
        if (field) this.expected = null;
        if (field && this.held?.control === focused && performance.now() < this.held.until) field.value = this.held.value;
    }

    hold({ dataset: { control }, value }) { this.held = { control, value, until: performance.now() + kHoldMs }; }

    row(label, ...controls) { return element("div", { class: "part_row" }, element("span", { class: "name" }, label), element("div", { class: "row" }, ...controls)); }

    choice(control, label, options, value, change) {
        const chosen = ({ target }) => {
            if (value) this.hold(target);  // others fall back to what they ask
            change(target.value);
        };
        return element("select", { "data-control": control, "aria-label": label, onchange: chosen },
            ...options.map(([key, text]) => element("option", { value: key, selected: key === value }, text)));
    }

    number(control, label, value, change, limits = {}) {
        return element("input", { type: "number", "data-control": control, "aria-label": label, value: Number(Number(value).toPrecision(6)), step: "any", ...limits,
            onchange: ({ target }) => {
                if (!Number.isFinite(target.valueAsNumber)) return;
                this.hold(target);
                change(target.valueAsNumber);
            } });
    }

    printer({ printers, printer }) {
        const known = printers.includes(printer) ? printers : [printer ?? "", ...printers];
        return [this.row("printer", this.choice("printer", "Printer", known.map((name) => [name, printerName(name)]), printer ?? "", (value) => this.edit({ path: ["printer"], value })))];
    }

    item(part, item, i) {
        if (!item.object) return [];
        const at = (key) => ["build", i, key];
        const size = part.sizes_mm[i];
        const rows = [];
        if (part.build.length > 1) rows.push(element("h3", {}, item.object));
        const object = part.objects?.[item.object] ?? {};
        const mesh = part.meshes?.[object.mesh] ?? {};
        if (size && !item.matrix) {
            rows.push(this.row("size", this.number(`size${i}`, "Longest side, mm", Math.max(...size), (mm) => this.edit({ path: at("scale"), value: scaleFor(item.scale, Math.max(...size), mm) }), { min: 0.01 }),
                element("span", { class: "type" }, `mm: ${size.map((v) => Number(v.toPrecision(4))).join(" × ")}`)));
        }
        if (mesh.file && !/\.(3mf|gl(tf|b))$/i.test(mesh.file)) {
            rows.push(this.row("read as", this.choice(`unit${i}`, "Unit of the file", kUnits, mesh.unit ?? "mm", (value) => this.edit({ path: ["meshes", object.mesh, "unit"], value })),
                element("label", { class: "type" }, element("input", { type: "checkbox", "data-control": `repair${i}`, checked: object.repair === "winding", onchange: (event) => this.edit(...editsOf(["objects", item.object, "repair"], event.target.checked ? "winding" : undefined)) }), "repair")));
        }
        if (!item.matrix) {
            const turn = item.rotate_deg ?? [0, 0, 0];
            rows.push(this.row("turn", ...["x", "y", "z"].map((axis, a) => this.number(`turn${axis}${i}`, `Turn about ${axis}, degrees`, turn[a], (degrees) => this.edit({ path: at("rotate_deg"), value: turn.map((v, b) => (b === a ? degrees : v)) }), { step: 90 })), "°"));
            const place = item.translate_mm ?? [0, 0];
            rows.push(this.row("place", ...["x", "y"].map((axis, a) => this.number(`place${axis}${i}`, `Place along ${axis}, mm`, place[a], (mm) => this.edit({ path: at("translate_mm"), value: place.map((v, b) => (b === a ? mm : v)) }))), "mm"));
            const count = item.grid?.count ?? [1, 1];
            const apart = item.grid?.spacing_mm ?? 2;
            const copies = (nx, ny, mm) => this.edit(...editsOf(at("grid"), nx * ny > 1 ? { count: [nx, ny], spacing_mm: mm } : undefined));
            rows.push(this.row("copies", this.number(`nx${i}`, "Copies along x", count[0], (n) => copies(Math.max(1, Math.round(n)), count[1] ?? 1, apart), { min: 1, step: 1 }), "×",
                this.number(`ny${i}`, "Copies along y", count[1] ?? 1, (n) => copies(count[0], Math.max(1, Math.round(n)), apart), { min: 1, step: 1 }),
                this.number(`apart${i}`, "Apart, mm", Array.isArray(apart) ? apart[0] : apart, (mm) => copies(count[0], count[1] ?? 1, mm), { min: 0 }), "mm"));
        } else rows.push(this.row("placed", element("span", { class: "type" }, "by a matrix, which the text of the world has")));
        return rows;
    }

    materials(part, objects) {
        const all = Object.entries(part.materials ?? {});
        const names = all.map(([name]) => name);
        const rows = all.map(([name, material]) => {
            const uses = usesOf(part, name);
            const preview = (material.preview ?? material.key).slice(0, 7).toLowerCase();
            const alpha = material.preview?.slice(7, 9) ?? "";
            return element("div", { class: "part_row" },
                element("div", { class: "row" }, element("input", { type: "color", value: preview, "data-control": `color ${name}`, "aria-label": `Look of ${name}`, onchange: (event) => this.edit({ path: ["materials", name, "preview"], value: event.target.value + alpha }) }), element("span", { class: "name", title: name }, name)),
                element("div", { class: "row" },
                    names.length > 1 ? this.choice(`swap ${name}`, `Swap ${name} with`, [["", "swap with …"], ...names.filter((one) => one !== name).map((one) => [one, one])], "", (other) => other && this.swap(part, name, other)) : "",
                    element("button", { class: "quiet", disabled: uses.length > 0, title: uses.length ? `in use: ${uses.join(", ")}` : "Take it out of the world", "aria-label": `Remove ${name}`, onclick: () => this.edit({ path: ["materials", name] }) }, "✕")));
        });
        const add = this.choice("add_material", "Add a material", [["", "add …"], ...kStock.map(([name]) => [name, name])], "", (name) => {
            if (!name) return;
            const made = materialFor(part.materials ?? {}, name);
            this.edit({ path: ["materials", made.name], value: made.value });
        });
        return [...rows, this.row("", add)];
    }

    /** A texture of the world to put on a side of an object. */
    pictures(part, objects, textures) {
        const on = (part.build ?? []).map((item, i) => ({ item, i })).filter(({ item }) => item.object && objects.some((one) => one.name === item.object));
        const materials = Object.keys(part.materials ?? {});
        if (textures.length === 0 || on.length === 0 || materials.length === 0) return [element("p", { class: "type" }, "Drop a picture on the page to put it on the part.")];
        const now = this.picture;
        now.texture = textures.includes(now.texture) ? now.texture : textures.at(-1);
        now.material = materials.includes(now.material) ? now.material : materials.at(-1);
        now.on = on.some(({ i }) => i === now.on) ? now.on : on[0].i;
        const put = (key) => (value) => { now[key] = value; };
        const named = (list) => list.map((one) => [one, one]);
        return [
            this.row("picture", this.choice("picture", "Picture", named(textures), now.texture, put("texture")), on.length > 1 ? this.choice("picture_on", "Part", on.map(({ item, i }) => [String(i), item.object]), String(now.on), (value) => { now.on = Number(value); }) : ""),
            this.row("on", this.choice("picture_side", "Side", kSides, now.side, put("side")), "in", this.choice("picture_ink", "Material of the picture", named(materials), now.material, put("material"))),
            this.row("wide", this.number("picture_width", "Width of the picture, mm", now.width, put("width"), { min: 0.1 }), "mm, deep", this.number("picture_depth", "Depth of the picture, mm", now.depth, put("depth"), { min: 0.01 }), "mm"),
            this.row("", element("button", { "data-control": "picture_put", onclick: () => this.putOn(part, objects) }, "Put it on")),
        ];
    }

    putOn(part, objects) {
        return this.run(async () => {
            const { texture, material, side, width, depth, on } = this.picture;
            const { object } = part.build[on];
            const of = objects.find((one) => one.name === object);
            const fabletName = of.fablet_name;
            const seen = new Image();
            seen.src = await getUrl("api/texture?" + query({ name: texture, volume: 0 }));
            await seen.decode();
            URL.revokeObjectURL(seen.src);
            const size = [width, width * (seen.naturalHeight || 1) / (seen.naturalWidth || 1)];
            const { text, bound } = await withPicture({ fablet: of.source, text: this.editor.text, fabletName, uniforms: of.uniforms, texture, material, side, size, middle: part.middles_mm[on] ?? [0, 0, 0], depth });
            // The names of the world's fablet come with its text: one after the other, as quickly as that goes.
            this.editor.replace(text);
            await this.editor.save();
            await postJson("api/part", { edits: Object.entries(bound).map(([name, value]) => ({ path: ["objects", object, "uniforms", name], value })) });
        });
    }

    swap(part, a, b) {
        const edits = swapped(part, a, b);
        if (edits.length) this.edit(...edits);
    }
}

// The column of details: materials with switches and colours, the picked voxel, this slice, the print.

import { count, describe, element, millimetres, share, volume } from "./format.js";

const byId = (id) => document.getElementById(id);

/** Lines for what became of what in a difference. */
const mostChanges = 12;

function voxelMl(print) {
    return print.pitch_mm[0] * print.pitch_mm[1] * print.pitch_mm[2] * 1e-3;
}

export class Panels {
    /** `changed` is called when colours or switches have changed. */
    constructor(model, changed) {
        this.model = model;
        this.changed = changed;
        this.scheme = "preview";
        this.looks = [];  // by material: {name, color, off}
        for (const button of document.querySelectorAll("[data-colors]"))
            button.addEventListener("click", () => this.setScheme(button.dataset.colors));
    }

    setScheme(scheme) {
        this.scheme = scheme;
        for (const look of this.looks) look.color = null;
        this.showMaterials();
        this.changed();
    }

    colorOf(index) {
        const material = this.model.print().materials[index];
        return this.looks[index]?.color ?? (this.scheme === "key" ? material.key : material.preview.slice(0, 7));
    }

    /** Colours by code, void first, as the server takes them; `clear`: with the materials' own transparency. */
    palette(clear) {
        const print = this.model.print();
        return "00000000" + print.materials.map((material, i) => {
            const own = clear && this.scheme === "preview" && !this.looks[i]?.color;
            const alpha = this.looks[i]?.off ? "00" : own ? material.preview.slice(7, 9).replace(/^0[0-3]$/, "04") : "ff";
            return this.colorOf(i).slice(1) + alpha;
        }).join("");
    }

    /** Everything that depends on the print; looks stay with materials of the same name. */
    showPrint() {
        const print = this.model.print();
        this.looks = print.materials.map((m, i) => (this.looks[i]?.name === m.name ? this.looks[i] : { name: m.name, color: null, off: false }));
        this.showMaterials();
        const rows = [
            ["Title", print.title || "–"],
            ["Printer", print.printer || "–"],
            ["Voxels", print.size.join(" × ")],
            ["Pitch", print.pitch_mm.map((p) => (p * 1000).toPrecision(4)).join(" × ") + " µm"],
            ["Size", print.size.map((n, a) => (n * print.pitch_mm[a]).toFixed(2)).join(" × ") + " mm"],
            ["Origin", print.origin_mm.map((o) => o.toFixed(3)).join(", ") + " mm"],
            ["Slices", `${print.slice_begin} … ${print.slice_end - 1}`],
            ["Finished", print.complete ? "yes" : `${print.whole} of ${print.slice_end - print.slice_begin} slices`],
        ];
        if (print.solid != null) {
            rows.push(["Solid", `${count(print.solid)} voxels, ${volume(print.solid * voxelMl(print))}`]);
            const grams = print.materials.reduce((sum, m) => sum + (m.voxels ?? 0) * voxelMl(print) * m.density_g_cm3, 0);
            rows.push(["Mass", `${grams.toFixed(2)} g`]);
            rows.push(["Hash", print.hash]);
        }
        for (const [name, value] of print.provenance) if (value.length <= 40) rows.push([name === "version of openfab" ? "OpenFab" : name, value]);
        for (const [i, event] of (print.story ?? []).entries()) rows.push([i === 0 ? "Story" : "", event]);
        describe(byId("stats"), rows);
    }

    showMaterials() {
        const print = this.model.print();
        const list = byId("materials");
        for (const button of document.querySelectorAll("[data-colors]"))
            button.setAttribute("aria-checked", button.dataset.colors === this.scheme);
        list.replaceChildren(...print.materials.map((material, i) => {
            const look = this.looks[i];
            const amount = material.voxels == null ? "" : volume(material.voxels * voxelMl(print));
            const part = print.solid ? (material.voxels ?? 0) / print.solid : 0;
            const bar = element("i");
            bar.style.width = `${100 * part}%`;
            return element("li", { class: look.off ? "off" : "" },
                element("input", {
                    type: "checkbox", id: `material_${i}`, checked: !look.off,
                    onchange: (event) => { look.off = !event.target.checked; event.target.closest("li").classList.toggle("off", look.off); this.changed(); },
                }),
                element("input", {
                    type: "color", value: this.colorOf(i), "aria-label": `Colour of ${material.name}`,
                    oninput: (event) => { look.color = event.target.value; this.changed(); },
                }),
                element("label", { for: `material_${i}`, title: `${material.name}${material.channel ? `, channel ${material.channel}` : ""}` }, material.name),
                element("span", { class: "amount", title: print.solid ? share(material.voxels, print.solid) : "" }, amount),
                ...(print.solid ? [element("span", { class: "bar" }, bar)] : []));
        }));
    }

    nameOf(code, print = this.model.print()) {
        return code === 0 ? "void" : print.materials[code - 1]?.name ?? `code ${code}`;
    }

    named(code) {
        if (code === 0) return ["void"];
        const swatch = element("span", { class: "swatch" });
        swatch.style.background = this.colorOf(code - 1);
        return [swatch, this.nameOf(code)];
    }

    showPick(picked) {
        const rows = [
            ["Material", this.named(picked.code)],
            ["Position", picked.mm.map((v) => v.toFixed(3)).join(", ") + " mm"],
            ["Voxel", picked.voxel.join(", ")],
        ];
        if (picked.other !== undefined) rows.splice(1, 0, ["in the other", this.named(picked.other)]);
        if (picked.part !== undefined) rows.push(["Part", picked.part || (picked.code ? "outside of the meshes" : "none")]);
        if (picked.has_amounts) {
            rows.push(["Before the dither:", picked.amounts || picked.trouble ? "" : "…", true]);
            if (picked.trouble) rows.push([picked.trouble, "", true]);
            const amounts = (picked.amounts ?? []).map((fraction, i) => [i + 1, fraction]);
            const solid = amounts.reduce((sum, [, fraction]) => sum + fraction, 0);
            for (const [code, fraction] of [...amounts, [0, 1 - solid]]) {
                if (picked.amounts && fraction > 5e-6) rows.push([element("span", {}, ...this.named(code)), `${(100 * fraction).toFixed(3)} %`]);
            }
        }
        const around = picked.around.filter((a) => a.share > 0);
        if (around.length > 1) {
            rows.push([`Within ${picked.around_mm.map((v) => v.toFixed(2)).join(" × ")} mm of the slice:`, "", true]);
            for (const { code, share: s } of around) rows.push([element("span", {}, ...this.named(code)), `${(100 * s).toFixed(1)} %`]);
        }
        describe(byId("pick"), rows);
    }

    showPickTrouble(text) { describe(byId("pick"), [[element("span", { class: "trouble" }, text), "", true]]); }

    showSliceTrouble(text) { describe(byId("slice_stats"), [[element("span", { class: "trouble" }, text), "", true]]); }

    /** What the address keeps of the materials: the scheme, which are off, and colours of one's own. */
    addressValues() {
        const which = (has) => this.looks.map((look, i) => (has(look) ? i + 1 : 0)).filter(Boolean);
        return {
            colors: this.scheme === "preview" ? undefined : this.scheme,
            off: which((look) => look.off).join(","),
            paint: which((look) => look.color).map((code) => `${code}:${this.looks[code - 1].color.slice(1)}`).join(","),
        };
    }

    applyAddress({ colors, off, paint }) {
        this.scheme = colors === "key" ? "key" : "preview";
        const hidden = (off ?? "").split(",").map(Number);
        const own = new Map((paint ?? "").split(",").map((one) => one.split(":")).filter(([, hex]) => /^[0-9a-f]{6}$/.test(hex)));
        this.looks.forEach((look, i) => {
            look.off = hidden.includes(i + 1);
            look.color = own.has(String(i + 1)) ? `#${own.get(String(i + 1))}` : null;
        });
        this.showMaterials();
    }

    showSlice(slice) {
        const print = this.model.print();
        byId("slice_title").textContent = `Slice ${slice.z}`;
        const solid = slice.voxels.reduce((sum, n, code) => sum + (code ? n : 0), 0);
        const rows = [["Height", millimetres(print.origin_mm[2] + (slice.z + 0.5) * print.pitch_mm[2])], ["Solid", `${count(solid)} voxels`]];
        slice.voxels.forEach((n, code) => { if (code && n) rows.push([element("span", {}, ...this.named(code)), `${count(n)} · ${share(n, solid)}`]); });
        if (slice.different !== undefined) {
            const most = slice.changes.sort((a, b) => b.voxels - a.voxels).slice(0, mostChanges);
            rows.push(["Different", `${count(slice.different)} voxels`]);
            for (const { first, second, voxels } of most)
                rows.push([element("span", {}, `${this.nameOf(first)} → ${this.nameOf(second, this.model.state.prints[1])}`), count(voxels)]);
        }
        describe(byId("slice_stats"), rows);
    }
}

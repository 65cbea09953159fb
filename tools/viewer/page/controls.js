// How a uniform is edited: one maker a kind. A maker gets what is edited and returns a control:
//
//   elements    what stands in the uniform's row
//   show(value) shows a value that came from elsewhere: a list, as the server writes it
//
// What is edited: `uniform` as `openflc describe` writes it, its `label`, `names` (materials and textures of the
// world) and `set`, which takes a value as the world would have it.

import { curve } from "./curve.js";
import { element } from "./format.js";
import { textureUrl } from "./textures.js";

/** The first that fits makes the control. */
const kControls = [
    { fits: (u) => u.kind === "curve", make: curve },
    { fits: (u) => u.array_length > 1, make: numbers },
    { fits: (u) => u.kind === "material", make: (of) => choice(of, of.names.materials) },
    { fits: (u) => u.kind === "texture2d" || u.kind === "texture3d", make: texture },
    { fits: (u) => u.choices, make: named },
    { fits: (u) => u.type === "bool", make: checkbox },
    { fits: isColor, make: color },
    { fits: (u) => u.kind === "value" && u.components === 1, make: slider },
    { fits: () => true, make: numbers },
];

export function controlOf(of) {
    return kControls.find((kind) => kind.fits(of.uniform)).make(of);
}

function named(of) {
    const { choices } = of.uniform;
    const list = choice(of, choices.map((c) => c.label));
    const labelOf = (value) => choices.find((c) => value === c.name || value === c.label || Number(value) === c.value)?.label;
    return { ...list, show: (value) => list.show([labelOf(value?.[0])]) };
}

function choice({ label, set }, names) {
    const select = element("select", { "aria-label": label, onchange: () => set(select.value) }, ...names.map((name) => element("option", {}, name)));
    return { elements: [select], show: (value) => { select.value = value?.[0] ?? ""; } };
}

/** With what the texture looks like. */
function texture(of) {
    const list = choice(of, of.names.textures);
    const picture = element("img", { class: "thumb", alt: "", hidden: true });
    const showPicture = async (name) => {
        const url = name ? await textureUrl(name, of.uniform.kind === "texture3d") : "";
        picture.hidden = !url;
        if (url) picture.src = url;
    };
    list.elements[0].addEventListener("change", (event) => showPicture(event.target.value));
    return { elements: [...list.elements, picture], show: (value) => { list.show(value); showPicture(value?.[0]); } };
}

function checkbox({ label, set }) {
    const box = element("input", { type: "checkbox", "aria-label": label, onchange: () => set(box.checked) });
    return { elements: [box], show: (value) => { box.checked = Boolean(value?.[0]); } };
}

function isColor(uniform) {
    if (uniform.kind !== "value" || uniform.type !== "float3") return false;
    return Object.entries(uniform.annotations).some(([name, text]) => /colou?r/i.test(name) || /colou?r/i.test(text));
}

function hexOf(values) {
    return "#" + values.map((v) => Math.round(255 * Math.min(Math.max(v, 0), 1)).toString(16).padStart(2, "0")).join("");
}

function numbersOf(hex) {
    return [1, 3, 5].map((i) => Number((parseInt(hex.slice(i, i + 2), 16) / 255).toFixed(4)));
}

function color({ label, set }) {
    const field = element("input", { type: "color", "aria-label": label, oninput: () => set(numbersOf(field.value)) });
    return { elements: [field], show: (value) => { field.value = hexOf(value ?? [0, 0, 0]); } };
}

function slider({ uniform, label, set, first }) {
    const given = (name) => (uniform.annotations[name] === undefined ? null : Number(uniform.annotations[name]));
    const start = first?.[0] ?? 0;
    // Without limits: twice the value, and below 0 where the value is.
    const low = given("min") ?? Math.min(0, -2 * Math.abs(start) * (start < 0));
    const high = given("max") ?? (start === 0 ? low + 1 : Math.max(low + Math.abs(start), 2 * Math.abs(start)));
    const step = given("step") ?? (uniform.type === "int" || uniform.type === "uint" ? 1 : Number(((high - low) / 200).toPrecision(1)));
    const range = element("input", { type: "range", min: low, max: high, step, "aria-label": label });
    const number = element("input", { type: "number", min: given("min"), max: given("max"), step: "any", "aria-label": `${label}, number` });
    range.addEventListener("input", () => { number.value = range.value; set(Number(range.value)); });
    number.addEventListener("change", () => { range.value = number.value; if (number.value !== "") set(Number(number.value)); });
    return { elements: [range, number], show: (value) => { range.value = number.value = value?.[0] ?? 0; } };
}

function numbers({ uniform, label, set, first }) {
    if (uniform.kind !== "value" || uniform.type === "bool" || !first) return { elements: [element("span", {}, "set in the world")], show: () => {} };
    const fields = first.map((_, i) => element("input", {
        type: "number", step: "any", "aria-label": `${label} ${i}`, min: uniform.annotations.min, max: uniform.annotations.max,
        onchange: () => { if (fields.every((f) => f.value !== "")) set(fields.map((f) => Number(f.value))); },
    }));
    return { elements: [element("span", { class: "many" }, ...fields)], show: (value) => fields.forEach((field, i) => { field.value = value?.[i] ?? ""; }) };
}

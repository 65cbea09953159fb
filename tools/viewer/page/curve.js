// A control for a curve, a uniform of type Spline or ColorRamp: keys are dragged, added by a double click and removed by
// a second one, or moved and removed by the keyboard.

import { element } from "./format.js";

const kWidth = 240, kHeight = 80, kPad = 8, kMostKeys = 16, kSteps = 96;

function svg(name, attributes = {}, ...children) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) {
        if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
        else made.setAttribute(key, value);
    }
    made.append(...children);
    return made;
}

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** Slopes as runtime/part/curve.cpp finds them. */
function slopes(x, y) {
    const width = (k) => x[k + 1] - x[k], rise = (k) => (y[k + 1] - y[k]) / width(k);
    const last = x.length - 1;
    if (last === 0) return [0];
    if (last === 1) return [rise(0), rise(0)];
    const end = (k, next) => {
        const h = width(k), more = width(next), near = rise(k), far = rise(next);
        const slope = ((2 * h + more) * near - h * far) / (h + more);
        if (slope * near <= 0) return 0;
        return near * far <= 0 && Math.abs(slope) > 3 * Math.abs(near) ? 3 * near : slope;
    };
    const out = [end(0, 1)];
    for (let k = 1; k < last; ++k) {
        const a = 2 * width(k) + width(k - 1), b = width(k) + 2 * width(k - 1);
        out.push(rise(k - 1) * rise(k) <= 0 ? 0 : (a + b) / (a / rise(k - 1) + b / rise(k)));
    }
    return [...out, end(last - 1, last - 2)];
}

/** The value of one channel at x, for drawing. */
function valueAt(keys, channel, how, at) {
    const x = keys.map((key) => key[0]), y = keys.map((key) => key[1 + channel]);
    const k = Math.max(0, x.findLastIndex((place) => at >= place));
    if (at <= x[0] || k + 1 >= x.length || how === "step") return y[at <= x[0] ? 0 : k];
    const h = x[k + 1] - x[k], d = at - x[k], rise = (y[k + 1] - y[k]) / h;
    if (how === "linear") return y[k] + rise * d;
    const m = slopes(x, y);
    return y[k] + d * (m[k] + d * ((3 * rise - 2 * m[k] - m[k + 1]) / h + (d * (m[k] + m[k + 1] - 2 * rise)) / (h * h)));
}

const hex = (rgb) => "#" + rgb.map((v) => Math.round(255 * clamp(v, 0, 1)).toString(16).padStart(2, "0")).join("");
const numbersOf = (text) => [1, 3, 5].map((i) => Number((parseInt(text.slice(i, i + 2), 16) / 255).toFixed(4)));
const rounded = (value) => Number(value.toPrecision(5));

/** Makes the control, as controls.js has it. */
export function curve({ uniform, label, set, first }) {
    if (!first?.[0]?.keys) return { elements: [element("span", {}, "set in the world")], show: () => {} };
    const colors = uniform.type === "ColorRamp";
    let keys, how, chosen = 0;
    const take = (value) => {
        keys = value.keys.map((key) => key.flat());
        how = value.interpolation ?? (colors ? "linear" : "cubic");
        chosen = Math.min(chosen, keys.length - 1);
    };
    take(first[0]);
    const given = (name) => (uniform.annotations[name] === undefined ? null : Number(uniform.annotations[name]));

    // What is seen stays while a key is dragged.
    let view;
    const frame = () => {
        const xs = keys.map((key) => key[0]), ys = keys.flatMap((key) => key.slice(1));
        const span = Math.max(...xs) - Math.min(...xs) || 1;
        const low = given("min") ?? Math.min(...ys), high = given("max") ?? Math.max(...ys);
        const room = given("min") === null || given("max") === null ? 0.15 * (high - low || Math.abs(high) || 1) : 0;
        view = {
            left: Math.min(...xs) - 0.08 * span, right: Math.max(...xs) + 0.08 * span,
            low: given("min") ?? low - room, high: given("max") ?? high + room,
        };
    };
    frame();
    const toX = (x) => kPad + ((x - view.left) / (view.right - view.left)) * (kWidth - 2 * kPad);
    const toY = (y) => kHeight - kPad - ((y - view.low) / (view.high - view.low)) * (kHeight - 2 * kPad);
    const fromX = (px) => view.left + ((px - kPad) / (kWidth - 2 * kPad)) * (view.right - view.left);
    const fromY = (py) => view.low + ((kHeight - kPad - py) / (kHeight - 2 * kPad)) * (view.high - view.low);

    const picture = svg("svg", { class: "curve", viewBox: `0 0 ${kWidth} ${kHeight}`, role: "group", "aria-label": label });
    const color = element("input", {
        type: "color", "aria-label": `${label}, colour of the key`,
        oninput: (e) => { keys[chosen].splice(1, 3, ...numbersOf(e.target.value)); changed(); },
    });
    const place = element("input", { type: "number", step: "any", "aria-label": `${label}, place of the key`, onchange: (e) => move(Number(e.target.value), null) });
    const amount = element("input", { type: "number", step: "any", "aria-label": `${label}, value of the key`, onchange: (e) => move(null, Number(e.target.value)) });
    const choice = element("select", { "aria-label": `${label}, between keys`, onchange: (e) => { how = e.target.value; changed(); } },
        ...["step", "linear", "cubic"].map((name) => element("option", { selected: name === how }, name)));

    function changed() {
        draw();
        set({ keys, interpolation: how });
    }

    /** Moves the chosen key, between its neighbours. */
    function move(x, y) {
        const gap = 1e-4 * (view.right - view.left);
        const low = chosen > 0 ? keys[chosen - 1][0] + gap : -Infinity;
        const high = chosen + 1 < keys.length ? keys[chosen + 1][0] - gap : Infinity;
        if (x !== null && Number.isFinite(x)) keys[chosen][0] = rounded(clamp(x, low, high));
        if (y !== null && Number.isFinite(y) && !colors)
            keys[chosen][1] = rounded(clamp(y, given("min") ?? -Infinity, given("max") ?? Infinity));
        changed();
    }

    function remove(k) {
        if (keys.length === 1) return;
        keys = keys.filter((_, i) => i !== k);
        chosen = Math.min(k, keys.length - 1);
        frame();
        changed();
        picture.querySelectorAll("circle")[chosen].focus();
    }

    function pointAt(e) {
        const box = picture.getBoundingClientRect();
        return [((e.clientX - box.left) / box.width) * kWidth, ((e.clientY - box.top) / box.height) * kHeight];
    }

    function add(e) {
        if (e.target.tagName === "circle" || keys.length >= kMostKeys) return;
        const [px, py] = pointAt(e), x = rounded(fromX(px));
        if (keys.some((key) => key[0] === x)) return;
        const values = colors ? [0, 1, 2].map((c) => valueAt(keys, c, how, x)) : [rounded(clamp(fromY(py), view.low, view.high))];
        keys = [...keys, [x, ...values]].sort((a, b) => a[0] - b[0]);
        chosen = keys.findIndex((key) => key[0] === x);
        changed();
    }

    function keyed(e, k) {
        const step = (e.shiftKey ? 0.1 : 0.01);
        const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[e.key];
        if (!by && e.key !== "Delete" && e.key !== "Backspace") return;
        e.preventDefault();
        chosen = k;
        if (!by) return remove(k);
        move(keys[k][0] + by[0] * step * (view.right - view.left), colors ? null : keys[k][1] + by[1] * step * (view.high - view.low));
    }

    function handle(key, k) {
        const at = colors ? kHeight / 2 : toY(key[1]);
        return svg("circle", {
            cx: toX(key[0]), cy: at, r: 5, tabindex: 0, role: "button", class: k === chosen ? "chosen" : "",
            "aria-label": `key ${k + 1}: at ${key[0]}, ${key.slice(1).join(" ")}`, ...(colors ? { fill: hex(key.slice(1)) } : {}),
            onfocus: () => { if (chosen !== k) { chosen = k; draw(k); } },
            onkeydown: (e) => keyed(e, k),
            onpointerdown: (e) => {
                e.preventDefault();
                chosen = k;
                picture.setPointerCapture(e.pointerId);
                draw(k);
            },
            ondblclick: () => remove(k),
        });
    }

    function draw(focus = [...picture.querySelectorAll("circle")].indexOf(document.activeElement)) {
        const parts = [];
        const xs = Array.from({ length: kSteps + 1 }, (_, i) => view.left + (i / kSteps) * (view.right - view.left));
        if (colors) {
            xs.slice(0, -1).forEach((x, i) => parts.push(svg("rect", {
                x: toX(x), y: kPad, width: (kWidth - 2 * kPad) / kSteps + 0.5, height: kHeight - 2 * kPad,
                fill: hex([0, 1, 2].map((c) => valueAt(keys, c, how, (x + xs[i + 1]) / 2))),
            })));
        } else {
            const points = xs.map((x) => [toX(x), toY(valueAt(keys, 0, how, x))]);
            const path = points.map(([x, y], i) => (i && how === "step" ? `H${x.toFixed(1)}V${y.toFixed(1)}` : `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`));
            parts.push(svg("path", { d: path.join("") }));
        }
        picture.replaceChildren(...parts, ...keys.map(handle));
        if (focus >= 0) picture.querySelectorAll("circle")[Math.min(focus, keys.length - 1)]?.focus();
        place.value = keys[chosen][0];
        amount.value = keys[chosen][1];
        color.value = hex(colors ? keys[chosen].slice(1) : [0, 0, 0]);
    }

    picture.addEventListener("dblclick", add);
    picture.addEventListener("pointermove", (e) => {
        if (!picture.hasPointerCapture(e.pointerId)) return;
        const [px, py] = pointAt(e);
        move(fromX(px), fromY(py));
    });
    picture.addEventListener("pointerup", () => { frame(); draw(); });
    draw();
    return {
        elements: [element("div", { class: "curved" }, picture, element("span", { class: "many" }, place, colors ? color : amount, choice))],
        show: (value) => {
            if (!value?.[0]?.keys) return;
            take(value[0]);
            choice.value = how;
            frame();
            draw();
        },
    };
}

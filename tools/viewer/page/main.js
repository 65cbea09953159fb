// Puts the page together: what is shown, and what keys and buttons do.

import { getJson, query } from "./api.js";
import { axisNames, millimetres } from "./format.js";
import { LivePanel } from "./live.js";
import { Panels } from "./panels.js";
import { PlaneView } from "./plane.js";
import { VolumeView } from "./volume.js";

const byId = (id) => document.getElementById(id);
const kSettleMs = 250;

const model = {
    state: null,
    view: "z",           // x, y, z or 3
    which: "0",          // a print, or diff
    at: { x: 0, y: 0, z: 0 },
    picked: null,
    moved: false,        // whether someone has chosen a slice or cut
    print: () => model.state?.prints[model.which === "1" ? 1 : 0],
    generation: () => model.state.generation,
    palette: () => panels.palette(model.view === "3"),
};

function notice(text) {
    byId("notice").textContent = text;
    byId("notice").hidden = !text;
}

function fail(error) {
    // A new print has taken the place of the one that was asked for.
    if (error.status === 409) return refresh();
    notice(error instanceof TypeError ? "the server does not answer; was `openfab view` ended?" : error.message);
}

const panels = new Panels(model, () => { plane.update(); volume.update(); });
const plane = new PlaneView(byId("plane"), model, {
    pick, fail, step, ready: () => notice(""),
    hover: (text) => { byId("hover").textContent = text; },
    zoomed: showScale,
});
const volume = new VolumeView(byId("volume"), model, {
    fail, notice, zoomed: showScale,
    scaleBar: (text, pixels) => { byId("hover").textContent = `${"―".repeat(Math.max(1, Math.round(pixels / 12)))} ${text}`; },
});
const live = new LivePanel(model, fail);

function showScale(scale) {
    byId("zoom").value = `${scale >= 100 ? scale.toFixed(0) : scale.toPrecision(3)} px/mm`;
}

function showing() { return model.view === "3" ? volume : plane; }

function limits() {
    const print = model.print();
    const axis = model.view === "3" ? "z" : model.view;
    if (axis === "z") return { axis, low: print.slice_begin, high: Math.max(print.slice_begin, print.slice_begin + print.whole - 1) };
    return { axis, low: 0, high: print.size[axisNames.indexOf(axis)] - 1 };
}

function showPlace() {
    const print = model.print();
    if (!print) return;
    const { axis, low, high } = limits();
    const a = axisNames.indexOf(axis);
    model.at[axis] = Math.min(Math.max(model.at[axis], low), high);
    for (const id of ["slider", "number"]) {
        const input = byId(id);
        [input.min, input.max] = [low, high];
        if (document.activeElement !== input || Number(input.value) !== model.at[axis]) input.value = model.at[axis];
    }
    byId("slider_label").textContent = axis === "z" ? "Slice" : `Cut ${axis}`;
    byId("number").setAttribute("aria-label", axis === "z" ? "Number of the slice" : `Voxel along ${axis}`);
    byId("height").value = `${axis} ${millimetres(print.origin_mm[a] + (model.at[axis] + 0.5) * print.pitch_mm[a])}`;
    byId("plane").setAttribute("aria-label", `${byId("slider_label").textContent} ${model.at[axis]}, ${byId("height").value}`);
}

let settling = 0;
/** What is worth a request only once one stays at a slice. */
function settle() {
    clearTimeout(settling);
    settling = setTimeout(async () => {
        if (!model.print()?.whole) return;
        try {
            panels.showSlice(await getJson("api/slice?" + query({ generation: model.generation(), print: model.which, z: model.at.z })));
        } catch (error) {
            fail(error);
        }
    }, kSettleMs);
}

function show() {
    if (!model.print()) return;
    showPlace();
    showing().update();
    settle();
}

function goTo(value) {
    if (!model.print() || !Number.isFinite(value)) return;
    model.moved = true;
    model.at[limits().axis] = Math.round(value);
    show();
}

function step(by) { goTo(model.at[limits().axis] + by); }

async function pick(voxel) {
    try {
        const picked = await getJson("api/pick?" + query({ generation: model.generation(), print: model.which, x: voxel[0], y: voxel[1], z: voxel[2] }));
        model.picked = { ...picked, voxel };
        axisNames.forEach((axis, a) => { if (axis !== model.view) model.at[axis] = voxel[a]; });
        panels.showPick(model.picked);
        plane.draw();
        if (picked.has_amounts) findAmounts();
    } catch (error) {
        fail(error);
    }
}

let findingAmounts = false;

/** One voxel at a time: after it the one that was picked last. */
async function findAmounts() {
    if (findingAmounts) return;
    findingAmounts = true;
    let of;
    do {
        of = model.picked;
        try {
            of.amounts = (await getJson("api/amounts?" + query({ generation: model.generation(), print: "0", x: of.voxel[0], y: of.voxel[1], z: of.voxel[2] }))).fractions;
        } catch (error) {
            of.trouble = error.message;
        }
        if (model.picked === of) panels.showPick(of);
    } while (model.picked && model.picked !== of && model.picked.has_amounts);
    findingAmounts = false;
}

function setView(view) {
    if (view === "3" && model.which === "diff") setWhich("0");
    model.view = view;
    notice("");
    byId("plane").hidden = view === "3";
    byId("volume").hidden = byId("clips").hidden = view !== "3";
    for (const button of document.querySelectorAll("[data-view]")) button.setAttribute("aria-checked", button.dataset.view === view);
    byId("hover").textContent = "";
    if (view !== "3") plane.axis = view;
    if (view !== "3") plane.resize();
    show();
}

function setWhich(which) {
    if (!model.state || (which !== "0" && !model.state.prints[1])) return;
    if (which === "diff" && (model.state.difference !== "" || model.view === "3")) {
        if (model.state.difference) notice(model.state.difference);
        return;
    }
    model.which = which;
    for (const button of document.querySelectorAll("[data-print]")) button.setAttribute("aria-checked", button.dataset.print === which);
    panels.showPrint();
    show();
}

function showState(state) {
    const before = model.state;
    model.state = state;
    byId("live").hidden = !state.live?.watch;
    live.showState(state.live);
    showProgress(state);
    const print = model.print();
    if (!print) {
        if (!state.live?.message) notice("waiting for the first slices …");
        return;
    }
    document.title = `${print.name} – OpenFab view`;
    byId("title").textContent = print.name;
    byId("subtitle").textContent = `${print.size.join(" × ")} voxels, ${print.size.map((n, a) => (n * print.pitch_mm[a]).toFixed(1)).join(" × ")} mm`
        + (state.prints[1] ? `, beside ${state.prints[1].name}` : "");
    byId("which").hidden = state.prints.length < 2;
    const old = before?.prints[model.which === "1" ? 1 : 0];
    const same = old && before.generation === state.generation;
    if (!same || old.whole !== print.whole || old.complete !== print.complete) {
        panels.showPrint();
        if (!same && (!old || old.size.join() !== print.size.join())) {
            // The middle of the print; its own place where a new one has other voxels.
            axisNames.forEach((axis, a) => { model.at[axis] = old ? Math.round((model.at[axis] + 0.5) * print.size[a] / old.size[a] - 0.5) : Math.floor(print.size[a] / 2); });
            model.picked = null;
        }
        if (!old) notice("");
        // Until somebody chooses: the newest of an unfinished print, the middle of a finished one.
        if (!model.moved) model.at.z = print.slice_begin + (print.complete ? Math.floor(print.whole / 2) : print.whole - 1);
        show();
    }
}

function showProgress(state) {
    const print = model.print();
    const text = byId("progress");
    let words = "";
    if (state.live && state.live.phase !== "done") {
        words = { checking: "compiling …", printing: "printing", failed: "failed", waiting: "waiting" }[state.live.phase] ?? "";
        if (state.live.phase === "printing" && state.live.slices_total) words += ` ${Math.floor(100 * state.live.slices_done / state.live.slices_total)} %`;
        if (state.live.phase === "failed" && !state.live.watch) notice(state.live.message);
    } else if (print && !print.complete) {
        words = `${print.whole} of ${print.slice_end - print.slice_begin} slices`;
    }
    text.textContent = words;
    text.hidden = !words;
    text.classList.toggle("failed", state.live?.phase === "failed");
}

let polling = 0;
async function refresh() {
    clearTimeout(polling);
    let again = 2000;
    try {
        const state = await getJson("api/state");
        showState(state);
        const busy = state.live && ["checking", "printing"].includes(state.live.phase);
        const growing = state.prints.some((p) => !p.complete);
        if (busy) again = 200;
        else if (growing || state.live?.watch) again = 500;
    } catch (error) {
        fail(error);
    }
    // Not while nobody looks.
    polling = setTimeout(() => (document.hidden ? document.addEventListener("visibilitychange", refresh, { once: true }) : refresh()), again);
}
live.refresh = refresh;

const keys = {
    ArrowUp: () => step(1), ArrowDown: () => step(-1), ArrowRight: () => step(1), ArrowLeft: () => step(-1),
    PageUp: () => step(10), PageDown: () => step(-10),
    Home: () => goTo(limits().low), End: () => goTo(limits().high),
    "+": () => showing().zoom(1.25), "=": () => showing().zoom(1.25), "-": () => showing().zoom(0.8), 0: () => showing().fit(),
    1: () => setView("z"), 2: () => setView("y"), 3: () => setView("x"), 4: () => setView("3"),
    a: () => setWhich("0"), b: () => setWhich("1"), d: () => setWhich("diff"),
    "?": () => byId("help").showModal(),
};
const moves = { ArrowUp: [0, 40], ArrowDown: [0, -40], ArrowLeft: [40, 0], ArrowRight: [-40, 0] };

document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || byId("help").open) return;
    const target = event.target;
    // Fields, buttons in a group and sliders have their own use of keys.
    if (target.matches("textarea, select, input:not([type=checkbox]):not([type=color])") && target.id !== "slider") return;
    if (!model.print() && event.key !== "?") return;
    if (event.shiftKey && moves[event.key]) {
        event.preventDefault();
        if (model.view === "3") volume.turnBy(...moves[event.key].map((v) => v / 2));
        else plane.pan(...moves[event.key]);
        return;
    }
    const action = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
});

for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => setView(button.dataset.view));
for (const button of document.querySelectorAll("[data-print]")) button.addEventListener("click", () => setWhich(button.dataset.print));
for (const button of document.querySelectorAll("[data-clip]")) {
    button.addEventListener("click", () => {
        const a = Number(button.dataset.clip);
        volume.clip[a] = !volume.clip[a];
        button.setAttribute("aria-pressed", volume.clip[a]);
        volume.draw();
    });
}
byId("slider").addEventListener("input", (event) => goTo(Number(event.target.value)));
byId("number").addEventListener("change", (event) => goTo(Number(event.target.value)));
byId("zoom_in").addEventListener("click", () => showing().zoom(1.25));
byId("zoom_out").addEventListener("click", () => showing().zoom(0.8));
byId("fit").addEventListener("click", () => showing().fit());
byId("help_button").addEventListener("click", () => byId("help").showModal());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plane.draw());

setView("z");
setWhich("0");
document.querySelector("[data-print='0']").setAttribute("aria-checked", true);
refresh();

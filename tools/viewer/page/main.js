// Puts the page together: what is shown, and what buttons do.

import { Address, numbersIn, readAddress } from "./address.js";
import { getJson, query } from "./api.js";
import { kStandpoints } from "./camera.js";
import { Cursor } from "./cursor.js";
import { Follower } from "./follow.js";
import { axisNames, element, millimetres } from "./format.js";
import { listenToKeys } from "./keys.js";
import { LivePanel } from "./live.js";
import { Measure } from "./measure.js";
import { Panels } from "./panels.js";
import { Pane, standInOrder } from "./panes.js";
import { savePicture } from "./picture.js";
import { PlaneView } from "./plane.js";
import { rove } from "./roving.js";
import { VolumeView } from "./volume.js";

const byId = (id) => document.getElementById(id);
const kSettleMs = 250;

const model = {
    state: null,
    view: "z",           // x, y, z or 3
    which: "0",          // a print, or diff
    at: { x: 0, y: 0, z: 0 },
    picked: null,
    chosen: false,       // whether the place was chosen, by someone or by what there is to see
    cutAxis: "z",        // the one that the slider moves in 3-D
    print: () => model.state?.prints[model.which === "1" ? 1 : 0],
    generation: () => model.state.generation,
    palette: () => panels.palette(model.view === "3"),
};

/** Over the picture: what keeps it from being shown. */
function notice(text) {
    byId("notice").textContent = text;
    byId("notice").hidden = !text;
}

/** Makes of a place for words one for errors; a print that another has replaced is no error, nor is a lost server one of that place. */
const tell = (show) => (error) => {
    if (error.status === 409) follower.refresh();
    else if (error.status === 0) follower.lost();
    else show(error.message);
};

const measure = new Measure(() => { redraw(); address.changed(); });
model.measure = measure;
const events = {
    pick, step, notice, fail: tell(notice), zoomed: showScale,
    measure: (mm) => measure.add(mm),
    moved: () => { if (model.chosen) address.changed(); },
    ready: () => notice(""),
    hover: (text) => { byId("hover").textContent = text; },
};
const panels = new Panels(model, () => { plane.update(); volume.update(); address.changed(); });
const plane = new PlaneView(byId("plane"), model, events);
const volume = new VolumeView(byId("volume"), byId("below"), byId("above"), model, events);
const cursor = new Cursor(byId("cursor"), showing);
const address = new Address(addressValues, applyAddress);
const follower = new Follower(showState, (error) => notice(error.message));
const live = new LivePanel({ refresh: () => follower.refresh(), tell, colorOfMaterial });

/** Red, green and blue of a material by its name; grey where there is none. */
function colorOfMaterial(name) {
    const hex = model.print()?.materials.find((one) => one.name === name)?.preview ?? "#808080";
    return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

function showing() { return model.view === "3" ? volume : plane; }

function redraw() {
    plane.draw();
    volume.draw();
}

function showScale(scale) {
    byId("zoom").value = `${scale >= 100 ? scale.toFixed(0) : scale.toPrecision(3)} px/mm`;
}

/** What the slider moves along, and how far. */
function limits() {
    const print = model.print();
    const axis = model.view === "3" ? model.cutAxis : model.view;
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
    const print = model.print();
    if (print) live.graph.looks.setPlane({ axis: axisNames.indexOf(limits().axis), point_mm: axisNames.map((axis, a) => print.origin_mm[a] + (model.at[axis] + 0.5) * print.pitch_mm[a]) });
    settling = setTimeout(async () => {
        if (!model.print()?.whole || (model.which === "diff" && model.state.difference)) return;
        try {
            panels.showSlice(await getJson("api/slice?" + query({ generation: model.generation(), print: model.which, z: model.at.z })));
        } catch (error) {
            tell((text) => panels.showSliceTrouble(text))(error);
        }
    }, kSettleMs);
}

function show() {
    if (!model.print()) return;
    showPlace();
    showing().update();
    settle();
    if (model.chosen) address.changed();
}

function goTo(value) {
    if (!model.print() || !Number.isFinite(value)) return;
    model.chosen = true;
    model.at[limits().axis] = Math.round(value);
    show();
}

function step(by) { goTo(model.at[limits().axis] + by); }

/** With `reach`, the nearest solid voxel of the slice. */
async function pick(voxel, reach = 0) {
    try {
        const [x, y, z] = voxel;
        const picked = await getJson("api/pick?" + query({ generation: model.generation(), print: model.which, x, y, z, reach }));
        model.picked = picked;
        // The planes that are not shown go there.
        axisNames.forEach((axis, a) => { if (axis !== model.view && !(model.view === "3" && volume.clip[a])) model.at[axis] = picked.voxel[a]; });
        panels.showPick(model.picked);
        live.graph.looks.setPoint(picked.mm);
        showPlace();
        settle();
        redraw();
        address.changed();
        if (picked.has_amounts) findAmounts();
    } catch (error) {
        tell((text) => panels.showPickTrouble(text))(error);
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

function check(selector, is) {
    for (const button of document.querySelectorAll(selector)) button.setAttribute("aria-checked", is(button));
}

function setView(view) {
    model.view = view;
    notice("");
    cursor.hide();
    byId("plane").hidden = view === "3";
    for (const id of ["volume", "below", "above", "clips", "standpoints"]) byId(id).hidden = view !== "3";
    check("[data-view]", (button) => button.dataset.view === view);
    byId("hover").textContent = "";
    if (view !== "3") plane.axis = view;
    if (view !== "3") plane.resize();
    show();
}

function setWhich(which) {
    if (!model.state || (which !== "0" && !model.state.prints[1])) return;
    if (which === "diff" && model.state.difference) return notice(model.state.difference);
    notice("");
    model.which = which;
    check("[data-print]", (button) => button.dataset.print === which);
    panels.showPrint();
    show();
}

function setClip(axis, on) {
    const a = axisNames.indexOf(axis);
    volume.clip[a] = on;
    document.querySelector(`[data-clip="${a}"]`).setAttribute("aria-pressed", on);
    // The slider moves the cut that was made last.
    if (on) model.cutAxis = axis;
    else if (model.cutAxis === axis) model.cutAxis = axisNames.find((_, i) => volume.clip[i]) ?? "z";
    showPlace();
    volume.draw();
    address.changed();
}

async function save() {
    const print = model.print();
    if (!print) return;
    const place = model.view === "3" ? "3-D" : `${model.view}-${model.at[model.view]}`;
    const name = [print.name.replace(/(\.ofr|\.fab\.json)$/, ""), model.which === "diff" ? "difference" : "", place].filter(Boolean).join("-");
    try {
        await savePicture(["plane", "below", "volume", "above"].map(byId), name);
    } catch (error) {
        notice(error.message);
    }
}

// The address.

function addressValues() {
    return {
        view: model.view,
        print: model.which === "0" ? undefined : model.which,
        at: axisNames.map((axis) => model.at[axis]).join(","),
        plane: model.view === "3" ? undefined : plane.text(),
        camera: model.view === "3" ? volume.camera.text() : undefined,
        cut: axisNames.filter((_, a) => volume.clip[a]).join(""),
        pick: model.picked?.voxel.join(","),
        measure: measure.points.flat().map((v) => Number(v.toFixed(4))).join(","),
        ...panels.addressValues(),
    };
}

function applyAddress(values) {
    if (!model.print()) return;
    const at = numbersIn(values.at, 3);
    if (at) {
        model.chosen = true;
        axisNames.forEach((axis, a) => { model.at[axis] = Math.min(Math.max(Math.round(at[a]), 0), model.print().size[a] - 1); });
    }
    panels.applyAddress(values);
    const camera = numbersIn(values.camera, 5);
    if (camera) volume.camera.set(camera);
    if (["0", "1", "diff"].includes(values.print)) setWhich(values.print);
    const points = numbersIn(values.measure, 6) ?? numbersIn(values.measure, 3) ?? [];
    measure.set([points.slice(0, 3), points.slice(3)].filter((point) => point.length === 3));
    for (const axis of axisNames) setClip(axis, Boolean(values.cut?.includes(axis)));
    setView(["x", "y", "z", "3"].includes(values.view) ? values.view : model.view);
    const window = numbersIn(values.plane, 3);
    if (window && window[2] > 0 && model.view !== "3") { plane.set(window); plane.update(); }
    const voxel = numbersIn(values.pick, 3);
    if (voxel) pick(voxel);
}

// The state of the server.

/** Until somebody chooses: the newest of an unfinished print, of a finished one the slice that shows most. */
async function findOpening() {
    const print = model.print();
    if (!print.complete) {
        model.at.z = print.slice_begin + Math.max(print.whole - 1, 0);
        return;
    }
    try {
        const { z } = await getJson("api/opening?" + query({ generation: model.generation(), print: "0" }));
        if (!model.chosen) model.at.z = z;
        model.chosen = true;
    } catch (error) {
        tell(notice)(error);
    }
}

function showState(state) {
    const before = model.state;
    model.state = state;
    for (const id of ["live", "modes"]) byId(id).hidden = !state.live?.watch;
    live.showState(state.live);
    if (state.live?.phase === "failed" && !state.live.watch) notice(state.live.message);
    const print = model.print();
    if (!print) {
        if (state.live?.phase === "failed" && state.live.watch) notice("Nothing is printed yet: see what is wrong beside this.");
        else if (!state.live?.message) notice("waiting for the first slices …");
        return;
    }
    document.title = `${print.name} – OpenFab view`;
    byId("title").textContent = print.name;
    byId("subtitle").textContent = `${print.size.join(" × ")} voxels, ${print.size.map((n, a) => (n * print.pitch_mm[a]).toFixed(1)).join(" × ")} mm`
        + (state.prints[1] ? `, beside ${state.prints[1].name}` : "");
    byId("which").hidden = state.prints.length < 2;
    const compare = document.querySelector("[data-print=diff]");
    compare.setAttribute("aria-disabled", Boolean(state.difference));
    compare.title = state.difference ? `No difference: ${state.difference}` : "Difference (D)";
    const old = before?.prints[model.which === "1" ? 1 : 0];
    const same = old && before.generation === state.generation;
    if (same && old.whole === print.whole && old.complete === print.complete) return;
    panels.showPrint();
    if (!same && (!old || old.size.join() !== print.size.join())) {
        // The middle of the print; its own place where a new one has other voxels.
        axisNames.forEach((axis, a) => { model.at[axis] = old ? Math.round((model.at[axis] + 0.5) * print.size[a] / old.size[a] - 0.5) : Math.floor(print.size[a] / 2); });
        model.picked = null;
    }
    if (!old) notice(print.whole ? "" : "waiting for the first slices …");
    if (!old) {
        // A part is looked at as one; two prints, or without WebGL2, by slices.
        if (!state.prints[1] && VolumeView.canDraw()) setView("3");
        applyAddress(readAddress());
    }
    if (model.chosen) show();
    else findOpening().then(show);
}

/** After a click, arrows go on to leaf through the picture; who came by keyboard stays among the buttons. */
function backToPicture(event) { if (event.detail) showing().canvas.focus({ preventScroll: true }); }

/** Presses a button of the live loop, if there is one. */
function press(id) {
    if (!model.state?.live?.watch) return false;
    byId(id).click();
    return true;
}

listenToKeys({ step, goTo, limits, showing, setView, setWhich, save, model, press, ready: () => Boolean(model.print()) }, cursor, byId("help"));
for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", (event) => { setView(button.dataset.view); backToPicture(event); });
for (const button of document.querySelectorAll("[data-print]")) button.addEventListener("click", (event) => { setWhich(button.dataset.print); backToPicture(event); });
for (const button of document.querySelectorAll("[data-clip]")) button.addEventListener("click", () => setClip(axisNames[button.dataset.clip], button.getAttribute("aria-pressed") !== "true"));
byId("standpoints").append(...Object.entries(kStandpoints).map(([name, { title }]) => element("button", { title, onclick: () => volume.stand(name) }, name)));
for (const group of document.querySelectorAll("[role=radiogroup], [role=tablist]")) rove(group, { choose: true });
for (const group of document.querySelectorAll("#clips, #standpoints")) rove(group);
byId("slider").addEventListener("input", (event) => goTo(Number(event.target.value)));
byId("number").addEventListener("change", (event) => goTo(Number(event.target.value)));
byId("zoom_in").addEventListener("click", () => showing().zoom(1.25));
byId("zoom_out").addEventListener("click", () => showing().zoom(0.8));
byId("fit").addEventListener("click", () => showing().fit());
byId("save_picture").addEventListener("click", save);
byId("help_button").addEventListener("click", () => byId("help").showModal());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);

if (matchMedia("(max-width: 1199px)").matches && matchMedia("(min-width: 901px)").matches) byId("details").hidden = true;
standInOrder();
new Pane("details");
setView("z");
check("[data-print]", (button) => button.dataset.print === "0");
follower.refresh();

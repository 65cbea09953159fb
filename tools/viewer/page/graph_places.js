// Where a hand has put the nodes of a graph, which of them are folded, and frames around some: all that the text has no
// place for. It may be lost without loss: whatever is not known here is laid out. Nothing here touches the page.
//
// Of a fablet: {tabs: {NAME: {at: {KEY: [x, y]}, folded: [KEY], frames: [{name, nodes: [KEY], folded}]}}}. Places count
// from that of the result, in the drawing's units; a key is what a node is called. All of it is never changed, only made anew.

import { heightOf, kSize, layout } from "./graph_layout.js";

const kPad = 14, kHead = 24, kMostFrames = 200;

export const nothing = Object.freeze({ tabs: {} });

const emptyTab = Object.freeze({ at: {}, folded: [], frames: [] });

/** What is known of a tab. What came from a file may be anything. */
export function placesOf(places, tab) {
    const { at, folded, frames } = places?.tabs?.[tab] ?? {};
    const names = (list) => (Array.isArray(list) ? list.filter((one) => typeof one === "string") : []);
    const fits = (place) => Array.isArray(place) && place.length === 2 && place.every((v) => Number.isFinite(v) && Math.abs(v) < 1e6);
    return {
        at: Object.fromEntries(Object.entries(at ?? {}).filter(([, place]) => fits(place))),
        folded: names(folded),
        frames: (Array.isArray(frames) ? frames : []).slice(0, kMostFrames).map((one) => ({ name: String(one?.name ?? ""), nodes: names(one?.nodes), folded: one?.folded === true })),
    };
}

/** Places with those of a tab changed by `change`, which gets what is known of it and returns what is other. */
export function changed(places, tab, change) {
    const before = placesOf(places, tab);
    const made = { ...emptyTab, ...before, ...change(before) };
    const tabs = { ...places.tabs, [tab]: made };
    if (!Object.keys(made.at).length && !made.folded.length && !made.frames.length) delete tabs[tab];
    return { tabs };
}

/** Places whose keys are other ones: `renamed` is a map. */
export function renamedKeys(places, tab, renamed) {
    if (renamed.size === 0) return places;
    const now = (key) => renamed.get(key) ?? key;
    return changed(places, tab, ({ at, folded, frames }) => ({
        at: Object.fromEntries(Object.entries(at).map(([key, place]) => [now(key), place])), folded: folded.map(now),
        frames: frames.map((one) => ({ ...one, nodes: one.nodes.map(now) })),
    }));
}

const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height + kSize.gap && b.y < a.y + a.height + kSize.gap;

function boundsOf(boxes) {
    if (boxes.length === 0) return { x: 0, y: 0, width: 0, height: 0 };
    const x = Math.min(...boxes.map((b) => b.x)), y = Math.min(...boxes.map((b) => b.y));
    return { x, y, width: Math.max(...boxes.map((b) => b.x + b.width)) - x, height: Math.max(...boxes.map((b) => b.y + b.height)) - y };
}

/**
 * Returns where nodes stand, {at, bounds, frames}, of keys `keys`, as `own` says and else as they are laid out: the last
 * node, the result, would be laid out at 0. A frame is {name, folded, nodes (their numbers), box}; nodes of a folded one all
 * stand at its box. `hiddenIn` is the number of that frame by node.
 */
export function arrange(nodes, keys, own) {
    const laid = layout(nodes);
    const origin = laid.at.at(-1) ?? { x: 0, y: 0 };
    const at = laid.at.map(({ x, y }) => ({ x: x - origin.x, y: y - origin.y }));
    const boxOf = (id) => ({ ...at[id], width: kSize.width, height: heightOf(nodes[id]) });
    const put = new Set();
    nodes.forEach((node, id) => {
        const place = own.at[keys[id]];
        if (!place) return;
        at[id] = { x: place[0], y: place[1] };
        put.add(id);
    });
    // What was not put anywhere gives way to what was.
    if (put.size) {
        const taken = [...put].map(boxOf);
        const free = nodes.map((node) => node.id).filter((id) => !put.has(id)).sort((a, b) => at[a].y - at[b].y);
        for (const id of free) {
            for (let box = boxOf(id), hit; (hit = taken.find((one) => overlap(box, one))); box = boxOf(id)) at[id] = { x: at[id].x, y: hit.y + hit.height + kSize.gap };
            taken.push(boxOf(id));
        }
    }
    const hiddenIn = new Map();
    const numbers = new Map(keys.map((key, id) => [key, id]));
    const frames = own.frames.map(({ name, nodes: inside, folded }) => {
        const ids = inside.map((key) => numbers.get(key)).filter((id) => id !== undefined);
        const around = boundsOf(ids.map(boxOf));
        const box = { x: around.x - kPad, y: around.y - kPad - kHead, width: around.width + 2 * kPad, height: around.height + 2 * kPad + kHead };
        return { name, folded, nodes: ids, box };
    });
    frames.forEach((frame, i) => {
        if (!frame.folded || frame.nodes.length === 0) return;
        const middle = { x: frame.box.x + (frame.box.width - kSize.width) / 2, y: frame.box.y + (frame.box.height - kHead) / 2 };
        frame.box = { ...middle, width: kSize.width, height: kHead };
        for (const id of frame.nodes) {
            if (hiddenIn.has(id)) continue;
            hiddenIn.set(id, i);
            at[id] = { ...middle };
        }
    });
    const seen = nodes.map((node) => node.id).filter((id) => !hiddenIn.has(id)).map(boxOf);
    return { at, frames, hiddenIn, bounds: boundsOf([...seen, ...frames.filter((one) => one.nodes.length).map((one) => one.box)]) };
}

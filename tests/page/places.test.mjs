// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Where a hand has put nodes: what is kept, how it meets the layout, and that it is undone with the text.

import assert from "node:assert/strict";
import test from "node:test";

import { heightOf, kSize, layout } from "../../tools/viewer/page/graph_layout.js";
import { arrange, changed, nothing, placesOf, renamedKeys } from "../../tools/viewer/page/graph_places.js";
import { TextHistory } from "../../tools/viewer/page/source_history.js";

const node = (id, froms, more = {}) => ({ id, kind: "call", title: "f", outputs: [{ name: "", type: "float" }], ports: froms.map((from) => ({ from, label: "x" })), ...more });
const chain = (count) => Array.from({ length: count }, (_, id) => node(id, id ? [id - 1] : []));
const keysOf = (nodes) => nodes.map((one) => `k${one.id}`);

test("without places nodes stand as they are laid out, the result at 0", () => {
    const nodes = chain(5);
    const laid = layout(nodes).at;
    const { at, bounds } = arrange(nodes, keysOf(nodes), placesOf(nothing, "@Volume"));
    at.forEach((place, i) => assert.deepEqual(place, { x: laid[i].x - laid[4].x, y: laid[i].y - laid[4].y }));
    assert.deepEqual(at[4], { x: 0, y: 0 });
    assert.equal(bounds.width, 4 * kSize.column + kSize.width);
});

test("a node stays where it was put while others come, and those give way to it", () => {
    const own = placesOf(changed(nothing, "a", () => ({ at: { k1: [-500, 40] } })), "a");
    for (const count of [3, 8]) {
        const nodes = chain(count);
        const { at } = arrange(nodes, keysOf(nodes), own);
        assert.deepEqual(at[1], { x: -500, y: 40 });
        for (const one of nodes) {
            if (one.id === 1) continue;
            const apart = Math.abs(at[one.id].x - at[1].x) >= kSize.width || at[one.id].y >= at[1].y + heightOf(nodes[1]) || at[one.id].y + heightOf(one) <= at[1].y;
            assert.ok(apart, `${one.id} of ${count}`);
        }
    }
});

test("nodes of a folded frame stand at its bar, others do not", () => {
    const nodes = chain(6);
    const own = { at: {}, folded: [], frames: [{ name: "part", nodes: ["k1", "k2", "gone"], folded: true }] };
    const { at, frames, hiddenIn } = arrange(nodes, keysOf(nodes), own);
    assert.deepEqual([...hiddenIn], [[1, 0], [2, 0]]);
    assert.deepEqual(at[1], at[2]);
    assert.deepEqual([at[1].x, at[1].y], [frames[0].box.x, frames[0].box.y]);
    const open = arrange(nodes, keysOf(nodes), { ...own, frames: [{ ...own.frames[0], folded: false }] });
    assert.equal(open.hiddenIn.size, 0);
    const { box } = open.frames[0];
    for (const id of [1, 2]) assert.ok(open.at[id].x >= box.x && open.at[id].y > box.y && open.at[id].x + kSize.width <= box.x + box.width);
});

test("a file that says anything else is as none", () => {
    const bad = { tabs: { a: { at: { x: [1], y: ["1", 2], z: [1e9, 0], w: [NaN, 1], fine: [1, 2] }, folded: "no", frames: [null, { nodes: [1, "k"] }] } } };
    assert.deepEqual(placesOf(bad, "a"), { at: { fine: [1, 2] }, folded: [], frames: [{ name: "", nodes: [], folded: false }, { name: "", nodes: ["k"], folded: false }] });
    for (const none of [null, undefined, {}, { tabs: null }, []]) assert.deepEqual(placesOf(none, "a"), { at: {}, folded: [], frames: [] });
});

test("a tab without places is left out, and a renamed node keeps its own", () => {
    const one = changed(nothing, "a", () => ({ at: { k: [1, 2] }, frames: [{ name: "f", nodes: ["k"], folded: false }] }));
    const renamed = renamedKeys(one, "a", new Map([["k", "m"]]));
    assert.deepEqual(renamed.tabs.a, { at: { m: [1, 2] }, folded: [], frames: [{ name: "f", nodes: ["m"], folded: false }] });
    assert.deepEqual(changed(one, "a", () => ({ at: {}, frames: [] })), { tabs: {} });
    assert.equal(one.tabs.a.at.k[0], 1, "what was is not changed");
});

test("moves and edits are undone in the order in which they were done", () => {
    const history = new TextHistory("one", "A");
    history.recordBeside("B");
    history.record("two");
    history.recordBeside("C");
    const seen = [];
    for (let i = 0; i < 4; ++i) seen.push([history.undo(), history.beside]);
    assert.deepEqual(seen, [["two", "B"], ["one", "B"], ["one", "A"], [null, "A"]]);
    for (const wanted of [["one", "B"], ["two", "B"], ["two", "C"]]) assert.deepEqual([history.redo(), history.beside], wanted);
    history.undo();
    history.recordBeside("D");
    assert.equal(history.canRedo, false);
});

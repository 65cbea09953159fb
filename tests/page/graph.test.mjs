// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The graph of the viewer's page: where nodes stand, what goes into what, and how values are written.

import assert from "node:assert/strict";
import test from "node:test";

import { familyOf, titleOf } from "../../tools/viewer/page/graph_draw.js";
import { heightOf, kSize, layout } from "../../tools/viewer/page/graph_layout.js";
import { canBeLookedAt, hasPicture, membersOf, short } from "../../tools/viewer/page/graph_look.js";
import { mayTake } from "../../tools/viewer/page/graph_palette.js";
import { inputsFor, nearestIn } from "../../tools/viewer/page/graph_wire.js";

const node = (id, froms, more = {}) => ({ id, kind: "call", title: "f", outputs: [{ name: "", type: "float" }], ports: froms.map((from) => ({ from: from ?? undefined, label: "x" })), ...more });

/** A graph with its result last, each node of which reads some before it. */
function randomNodes(count, seed) {
    let state = seed;
    const dice = (below) => (state = (state * 1103515245 + 12345) & 0x7fffffff) % below;
    const nodes = Array.from({ length: count }, (_, id) => node(id, id ? Array.from({ length: dice(4) }, () => dice(id)) : []));
    nodes.push(node(count, [count - 1], { kind: "result", outputs: [] }));
    return nodes;
}

test("what a node reads stands left of it, and nodes of a column do not touch", () => {
    for (const [count, seed] of [[1, 1], [12, 2], [80, 3], [300, 4], [300, 5]]) {
        const nodes = randomNodes(count, seed);
        const { at, width, height } = layout(nodes);
        for (const one of nodes) for (const port of one.ports) assert.ok(port.from === undefined || at[port.from].x < at[one.id].x);
        const columns = new Map();
        for (const one of nodes) columns.set(at[one.id].x, [...columns.get(at[one.id].x) ?? [], one]);
        for (const column of columns.values()) {
            column.sort((a, b) => at[a.id].y - at[b.id].y);
            for (let i = 1; i < column.length; ++i)
                assert.ok(at[column[i].id].y >= at[column[i - 1].id].y + heightOf(column[i - 1]) + kSize.gap - 1e-6);
        }
        for (const place of at) assert.ok(place.x >= 0 && place.x + kSize.width <= width && place.y >= -1e-6 && place.y < height);
    }
});

test("a loop, which no graph has, does not hang", () => {
    const nodes = [node(0, [1]), node(1, [0])];
    assert.equal(layout(nodes).at.length, 2);
    assert.deepEqual(layout([]), { at: [], width: kSize.width, height: 0 });
});

test("names of types say what may go into what", () => {
    for (const [wants, type] of [["float3", "float"], ["floatN", "float2"], ["float", "int"], ["T", "Material"], ["Material", "Material"], ["float4", "float4"]]) assert.ok(mayTake(wants, type), `${type} into ${wants}`);
    for (const [wants, type] of [["float", "float3"], ["float2", "float3"], ["Material", "float"], ["float", "MaterialComposition"]]) assert.ok(!mayTake(wants, type), `${type} into ${wants}`);
});

test("titles say the variable and what computes it", () => {
    assert.equal(titleOf({ kind: "call", title: "smoothstep", outputs: [{ name: "t" }] }), "t = smoothstep");
    assert.equal(titleOf({ kind: "write", title: ".Set", outputs: [{ name: "mc" }] }), "mc.Set");
    assert.equal(titleOf({ kind: "value", title: "1", outputs: [{ name: "a" }] }), "a");
    assert.deepEqual(["float", "bool", "int3", "Material", "MaterialComposition", "ImageTexture2D"].map(familyOf), ["number", "truth", "vector", "material", "mixture", "other"]);
});

test("values are short, and members are theirs", () => {
    assert.deepEqual([1 / 3, 1e-9, 123456, "nan"].map(short), ["0.3333", "1e-9", "123500", "nan"]);
    assert.deepEqual(membersOf([1, 2, 3], ".zx"), [3, 1]);
    assert.deepEqual(membersOf([1, 2, 3], ""), [1, 2, 3]);
    assert.ok(canBeLookedAt(node(0, [])) && !canBeLookedAt(node(0, [], { outputs: [{ type: "Material" }] })));
    assert.ok(!hasPicture(node(0, [], { role: "uniform" })));
});

test("a wire goes to inputs that take it, to those of its very type first, never to what it is made of", () => {
    const nodes = [
        { id: 0, kind: "call", title: "a", outputs: [{ name: "", type: "float" }], ports: [] },
        { id: 1, kind: "call", title: "b", outputs: [{ name: "", type: "float" }], ports: [{ from: 0, output: 0, begin: 3, wants: "float" }] },
        { id: 2, kind: "call", title: "c", outputs: [{ name: "", type: "float" }], ports: [{ from: 1, output: 0, begin: 9, wants: "float3" }, { begin: 12, wants: "float" }, { wants: "float" }, { begin: 14, wants: "Material" }] },
        { id: 3, kind: "result", title: "return", outputs: [], ports: [{ from: 1, output: 0, begin: 20, wants: "float" }] },
    ];
    const place = (node, i) => ({ x: 100 * node.id, y: 10 * i });
    const found = inputsFor(nodes, 1, 0, place, { x: 100, y: 0 }).map(({ node, port }) => [node, port]);
    assert.deepEqual(found, [[2, 1]]);  // 2.0 and 3.0 have this wire, 2.2 is no place of the text, 2.3 is a material, 1.0 and 0 are before
    assert.deepEqual(inputsFor(nodes, 0, 0, place, { x: 0, y: 0 }).map(({ node, port }) => [node, port]), [[2, 1], [3, 0], [2, 0]]);
    assert.deepEqual(inputsFor(nodes, 2, 0, place, { x: 200, y: 0 }).map(({ node, port }) => [node, port]), [[3, 0]]);
});

test("an arrow goes to the nearest in its direction, one straight ahead before one aside", () => {
    const places = [{ x: 0, y: 0, id: 0 }, { x: 100, y: 0, id: 1 }, { x: 60, y: 50, id: 2 }, { x: 0, y: 40, id: 3 }];
    assert.equal(nearestIn(places, places[0], [1, 0]).id, 1);
    assert.equal(nearestIn(places, places[0], [0, 1]).id, 3);
    assert.equal(nearestIn(places, places[0], [-1, 0]), undefined);
});

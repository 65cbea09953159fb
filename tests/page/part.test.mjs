// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the panel "Part" makes of a wish: changes of a world.

import assert from "node:assert/strict";
import test from "node:test";

import { editsOf, kStock, materialFor, scaleFor, swapped, usesOf } from "../../tools/viewer/page/part_edits.js";
import { callOf } from "../../tools/viewer/page/part_picture.js";

test("a size is a scale, whatever there was", () => {
    assert.equal(scaleFor(undefined, 12, 60), 5);
    assert.equal(scaleFor(2, 24, 60), 5);
    assert.deepEqual(scaleFor([1, -2, 3], 30, 60), [2, -4, 6]);
});

test("a new material has a name and a key of its own", () => {
    const materials = {};
    for (let i = 0; i < 3; ++i) for (const [name] of kStock) {
        const made = materialFor(materials, name);
        materials[made.name] = made.value;
    }
    assert.equal(Object.keys(materials).length, 3 * kStock.length);
    assert.equal(new Set(Object.values(materials).map((one) => one.key)).size, 3 * kStock.length);
    for (const { key, preview } of Object.values(materials)) assert.ok(/^#[0-9a-f]{6}$/.test(key) && /^#[0-9a-f]{6}([0-9a-f]{2})?$/.test(preview), key);
});

test("materials are swapped where they are used, and used ones are told", () => {
    const world = { objects: { cup: { uniforms: { core: "white", shell: "black", many: ["white", "red"], skin: 0.5 } }, lid: { uniforms: { core: "black" } }, bare: {} } };
    assert.deepEqual(usesOf(world, "white"), ["core of cup", "many of cup"]);
    assert.deepEqual(usesOf(world, "red"), ["many of cup"]);
    assert.deepEqual(swapped(world, "white", "black"), [
        { path: ["objects", "cup", "uniforms", "core"], value: "black" }, { path: ["objects", "cup", "uniforms", "shell"], value: "white" },
        { path: ["objects", "cup", "uniforms", "many"], value: ["black", "red"] }, { path: ["objects", "lid", "uniforms", "core"], value: "white" }]);
    assert.deepEqual(editsOf(["a"], undefined), [{ path: ["a"] }]);
    assert.deepEqual(editsOf(["a"], 0), [{ path: ["a"], value: 0 }]);
});

test("a picture's call has what was chosen, at the compiler's own point", () => {
    assert.equal(callOf("mix_picture_on(f(a, b), core, old, attr.voxelCenter)", { body: "f(a, b)", ink: "ink", picture: "picture", side: "4", size: [20, 10.1234567], middle: [0, 1, -2], depth: 0.5 }),
        "mix_picture_on(f(a, b), ink, picture, attr.voxelCenter, 4, float2(20, 10.1235), float3(0, 1, -2), 0.5)");
});

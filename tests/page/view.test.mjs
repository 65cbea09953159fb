// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The viewer's page on prints: where the volume is seen from, what a ray meets, and how lengths are written.

import assert from "node:assert/strict";
import test from "node:test";

import { numbersIn } from "../../tools/viewer/page/address.js";
import { Camera, kStandpoints } from "../../tools/viewer/page/camera.js";
import { lengthText, roundLength } from "../../tools/viewer/page/format.js";
import { firstHit } from "../../tools/viewer/page/rays.js";

const near = (a, b) => assert.ok(a.every((v, i) => Math.abs(v - b[i]) < 1e-9), `${a} for ${b}`);

test("standard views look along their axes, upright", () => {
    const camera = new Camera();
    const seen = { top: [[1, 0, 0], [0, 1, 0]], front: [[1, 0, 0], [0, 0, 1]], back: [[-1, 0, 0], [0, 0, 1]], right: [[0, 1, 0], [0, 0, 1]], left: [[0, -1, 0], [0, 0, 1]] };
    for (const [name, [right, up]] of Object.entries(seen)) {
        camera.stand(name);
        const look = camera.look([10, 20, 30], 400, 300);
        near(look.right, right);
        near(look.up, up);
    }
    assert.ok(Object.keys(kStandpoints).length === 7);
});

test("the address brings a camera back", () => {
    const camera = new Camera();
    camera.turnBy(0.3, 0.2);
    camera.zoom(2);
    const other = new Camera();
    other.set(numbersIn(camera.text(), 5));
    assert.equal(other.text(), camera.text());
    assert.equal(numbersIn("1,2,x", 3), null);
    assert.equal(numbersIn("", 3), null);
});

test("a ray stops at the first cell that hides what is behind it, and at a cut", () => {
    const cells = [8, 8, 8];
    const bytes = new Uint8Array(4 * 512);
    // A solid ball of radius 3 cells, a clear cell before it.
    for (let z = 0; z < 8; ++z) for (let y = 0; y < 8; ++y) for (let x = 0; x < 8; ++x)
        if (Math.hypot(x - 3.5, y - 3.5, z - 3.5) < 3) bytes[((z * 8 + y) * 8 + x) * 4 + 3] = 255;
    bytes[((4 * 8 + 0) * 8 + 4) * 4 + 3] = 10;
    const ray = { bytes, cells, size: [8, 8, 8], low: [-4, -4, -4], high: [4, 4, 4], from: [0.5, -20, 0.5], way: [0, 1, 0], step: 0.1 };
    const hit = firstHit(ray);
    assert.ok(hit[1] > -3.05 && hit[1] < -2.7, `${hit}`);
    assert.ok(Math.abs(firstHit({ ...ray, low: [-4, 0, -4] })[1]) < 0.1, "the face of a cut");
    assert.equal(firstHit({ ...ray, from: [3.9, -20, 3.9] }), null);
});

test("lengths are round, and have their units", () => {
    assert.deepEqual([0.7, 1.9, 3, 9, 120].map(roundLength), [0.5, 1, 2, 5, 100]);
    assert.equal(lengthText(0.0271), "27.1 µm");
    assert.equal(lengthText(12.34567), "12.35 mm");
});

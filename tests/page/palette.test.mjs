// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The list of nodes: what plain words find, and that each function of the library stands in a category of its own kind.

import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import test from "node:test";

import { categoryOf, kCategories, plainWords, rate } from "../../tools/viewer/page/palette_words.js";

const entry = (name, more = {}) => ({ kind: "library", module: "", name, signature: `float ${name}(float x)`, help: "", result: "float", parameters: [], ...more });

test("every module of the library has a category", () => {
    for (const file of readdirSync(new URL("../../stdlib", import.meta.url))) {
        if (!file.endsWith(".fl")) continue;
        const one = categoryOf(entry("f", { module: file.slice(0, -3) }));
        assert.notEqual(one.name, "Mathematics", file);
    }
    assert.equal(new Set(kCategories.map((one) => one.name)).size, kCategories.length);
});

test("what people call a thing finds it first", () => {
    const all = [entry("checks", { module: "pattern" }), entry("gyroid", { module: "lattice", help: "A gyroid lattice, in a checker of cells" }), entry("Sample3", { kind: "method" }), entry("solid_cylinder", { module: "solids" }),
        entry("grade_depth", { module: "grade" }), entry("map_planar", { module: "mapping" }), entry("sin", { kind: "builtin" })];
    const best = (text) => {
        const words = text.split(" ");
        return all.map((one) => [rate(one, words), one.name]).filter(([rated]) => rated >= 0).sort((a, b) => a[0] - b[0])[0]?.[1];
    };
    for (const [text, name] of [["checker", "checks"], ["photo", "Sample3"], ["logo", "Sample3"], ["drill", "solid_cylinder"], ["graded", "grade_depth"], ["gyr", "gyroid"], ["sin", "sin"], ["tpms", "gyroid"]])
        assert.equal(best(text), name, text);
    assert.equal(best("hole"), "solid_cylinder");
    assert.equal(best("nothingatall"), undefined);
});

test("an entry is said in one line without code", () => {
    assert.equal(plainWords(entry("f", { help: "A wave of `x`. And more." })), "A wave of x");
    assert.equal(plainWords(entry("f", { help: "Up to 0.5 of it, and so on" })), "Up to 0.5 of it, and so on");
    assert.equal(plainWords(entry("solid_new_thing")), "new thing");
    assert.equal(plainWords(entry("checks", { kind: "own", help: "Mine." })), "Mine");
});

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The schema that the extension gives editors: every world of the gallery fits it, and mistakes do not.

const assert = require("node:assert");
const { execFileSync } = require("node:child_process");
const fs = require("node:fs");
const path = require("node:path");
const { test } = require("node:test");
const Ajv = require("ajv/dist/2020");

const root = path.join(__dirname, "..", "..", "..");
const read = (file) => JSON.parse(fs.readFileSync(file, "utf8"));
const schema = read(path.join(__dirname, "..", "schemas", "fab_world.schema.json"));
const valid = new Ajv({ strict: false, allErrors: true }).compile(schema);

test("the worlds of the gallery fit the schema", () => {
    const files = execFileSync("git", ["ls-files", "gallery/**/*.fab.json"], { cwd: root, encoding: "utf8" }).trim().split("\n");
    assert.ok(files.length > 10, `${files.length} worlds`);
    for (const file of files) assert.ok(valid(read(path.join(root, file))), `${file}: ${JSON.stringify(valid.errors)}`);
});

test("mistakes do not fit", () => {
    const world = read(path.join(root, "gallery", "gyroid_block", "gyroid.fab.json"));
    for (const change of [{ openfab: 2 }, { colour: 1 }, { build: {} }, { meshes: [] }])
        assert.ok(!valid({ ...world, ...change }), JSON.stringify(change));
    const { objects, ...rest } = world;
    assert.ok(!valid(rest), "a world without objects");
});

test("the extension's files are there", () => {
    const extension = path.join(__dirname, "..");
    const manifest = read(path.join(extension, "package.json"));
    for (const one of manifest.contributes.jsonValidation) assert.ok(fs.existsSync(path.join(extension, one.url)), one.url);
    for (const one of manifest.contributes.grammars) read(path.join(extension, one.path));
    for (const one of manifest.contributes.languages) read(path.join(extension, one.configuration));
    assert.ok(fs.existsSync(path.join(extension, manifest.main)));
});

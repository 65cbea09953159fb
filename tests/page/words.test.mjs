// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Whatever programs say, the page names no option of a command and no temporary folder: every row of every catalogue of messages.

import assert from "node:assert/strict";
import { readdirSync, readFileSync, statSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";

import { inPageWords, kNotHere, pageWords } from "../../tools/viewer/page/page_words.js";

const root = new URL("../..", import.meta.url).pathname;
const kFolder = "/tmp/openfab.tmp-aB3dE9/dropped/";
const kOption = /(^|[\s`(,=])--(?:[a-z][a-z]|z )|openfab (?!view`)[a-z]|scripts\/|openfab\.tmp-/;

const kLeft = /[,;]\s*\(|[,;]$|\b[Ii]f that is wrong$/m;

/** The rows of all catalogues: {file, name, text}. */
function rows() {
    const found = [];
    const visit = (folder) => {
        for (const name of readdirSync(folder)) {
            const path = join(folder, name);
            if (["build", "out", "node_modules", ".git"].includes(name)) continue;
            if (statSync(path).isDirectory()) visit(path);
            else if (name.endsWith("messages.h")) {
                for (const [, row, literals] of readFileSync(path, "utf8").matchAll(/OPENFAB_MESSAGE\((\w+),\s*((?:"(?:[^"\\]|\\.)*"\s*)+)\)/g))
                    found.push({ file: path.slice(root.length), name: row, text: [...literals.matchAll(/"(?:[^"\\]|\\.)*"/g)].map(([one]) => JSON.parse(one)).join("") });
            }
        }
    };
    visit(root);
    return found;
}

test("no message of any program brings an option, a command or a temporary folder to the page", () => {
    const all = rows();
    assert.ok(all.length > 3000, `${all.length} rows`);
    assert.ok(all.filter(({ text }) => kOption.test(text)).length > 250);
    for (const { file, name, text } of all) {
        // As it is, as an error, as an error at a place with its remedy in a line of its own, and about a dropped file.
        const of_file = text.replace(/\{[^}]*\}/, `${kFolder}cup.stl`);
        for (const said of [text, `error: ${text}`, `a.fab.json:3:7: error: the mesh is not closed\n 3 |   "mesh": 1\n   |           ^\nhelp: ${text}\n`, of_file, `error: ${of_file}; ${text}`]) {
            const shown = pageWords(said);
            assert.ok(shown.trim(), `${file} ${name}`);
            for (const line of shown.split("\n")) {
                assert.doesNotMatch(line, kOption, `${file} ${name}`);
                // Nor what is left of a clause that was about one.
                if (!kLeft.test(said)) assert.doesNotMatch(line, kLeft, `${file} ${name}: ${line}`);
            }
        }
    }
});

test("of what reads worlds, meshes, pictures and prints on the page there is always something left", () => {
    // A remedy, or an option that the page never gives.
    const remedies = /Help$|^kGive|^kAllowMore|^k(?:OrAPicture|FewerThreads|ImportVrml|ImportRemedy|PicturesWithout)/;
    const options = new Set(["kNoSuchSlice", "kHelpLists", "kHeightsAndSlices", "kFractionsNoVdb", "kCentreAndSupersample", "kResumeWithoutOutput", "kCannotResume", "kSlicesFillAFolder", "kOutputNoVdb", "kNoPalette",
        "kNotMirrored", "kMeshPitchOfSlices", "kGreyMaterialWithoutPictures", "kSlicesOutside", "kNoSliceInRange", "kBleedNotKnown"]);
    for (const { file, name, text } of rows()) {
        if (!/^(world|core|runtime|program|client|tools\/viewer|backends\/(?!stream))/.test(file) || remedies.test(name) || options.has(name) || /^`?--/.test(text)) continue;
        assert.notEqual(pageWords(text), kNotHere, `${file} ${name}: ${text}`);
    }
});

test("what is left is what was said", () => {
    assert.equal(pageWords("the image takes more memory than is allowed; allow more, as with `--memory 4GB`"), "the image takes more memory than is allowed");
    assert.equal(pageWords("note: `a.obj` gives no unit: taken as millimetres, 2 x 2 x 2 mm. If that is wrong, import it with `--unit cm` (or m, um, in) or `--size 60mm`"), "note: `a.obj` gives no unit: taken as millimetres, 2 x 2 x 2 mm. If that is wrong, choose another at `read as`");
    assert.equal(pageWords("put it there, or allow it with `--allow ../x`"), "put it there");
    assert.equal(pageWords("it takes 3 GB of memory, more than the 1 GB of `--memory`; scale it down, or give it `--memory 3000MB`"), "it takes 3 GB of memory, more than the 1 GB that are allowed; scale it down");
    assert.equal(pageWords("error: --set ball.skin=9: above its max"), "error: ball.skin=9: above its max");
    assert.equal(pageWords(`${kFolder}open.obj is not closed`), "open.obj is not closed");
    assert.equal(pageWords("/var/tmp/deep/openfab.tmp-aB3dE9/openfab.tmp-aB3dE8/made/x.obj: no faces"), "x.obj: no faces");
    assert.equal(pageWords("a.fl:3:5: error: `--i` changes nothing\n 3 |     --i;\n   |     ^~~\n"), "a.fl:3:5: error: `--i` changes nothing\n 3 |     --i;\n   |     ^~~\n");
    assert.equal(pageWords("allow more, as with `--memory 4GB`"), kNotHere);
    assert.equal(pageWords("a - b; c -- d"), "a - b; c -- d");
    assert.equal(inPageWords("text", "// --memory"), "// --memory");
    assert.equal(inPageWords("message", "note: x; `--draft 2` is finer"), "note: x");
});

test("nor do the page's own words", () => {
    const folder = join(root, "tools/viewer/page");
    for (const name of readdirSync(folder)) {
        if (name === "page_words.js" || name.endsWith(".css")) continue;
        const text = readFileSync(join(folder, name), "utf8").replace(/^\s*\/\/.*$/gm, "").replace(/\/\*\*[^*]*\*\//g, "");
        assert.doesNotMatch(text.replace(/openfab view<\/code>/g, ""), /["'`>][^"'`<]*(?:\s--[a-z]|`--[a-z]|\bopenfab [a-z]|\bscripts\/)/, name);
    }
});

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The editor of the viewer's page: colours, keys, completions and the history, as far as they need no page.

import assert from "node:assert/strict";
import test from "node:test";

import { fitting, plain } from "../../tools/viewer/page/source_assist.js";
import { endOfChange, TextHistory } from "../../tools/viewer/page/source_history.js";
import { closing, comment, fromSnippet, indent, newline, outdent } from "../../tools/viewer/page/source_keys.js";
import { commentStarts, wordBefore, wordsOf } from "../../tools/viewer/page/source_words.js";

const kinds = (line, inside) => wordsOf(line, inside).words.map((word) => [line.slice(word.begin, word.end), word.kind]);

/** A text with what is chosen between bars, and back. */
const chosen = (marked) => {
    const [before, inside, after] = marked.split("|").length === 3 ? marked.split("|") : [marked.split("|")[0], "", marked.split("|")[1]];
    return { text: before + inside + after, begin: before.length, end: before.length + inside.length };
};
const marked = ({ text, begin, end }) => (begin === end ? `${text.slice(0, begin)}|${text.slice(begin)}` : `${text.slice(0, begin)}|${text.slice(begin, end)}|${text.slice(end)}`);

test("words have their kinds", () => {
    assert.deepEqual(kinds("float3 t = .5e-1f * sin(attr.p) / 0x1Fu; // or so"), [["float3", "type"], [".5e-1f", "number"], ["sin", "function"], ["p", "member"], ["0x1Fu", "number"], ["// or so", "comment"]]);
    assert.deepEqual(kinds('@Volume(@varying { VolumeAttributes attr }) [[ string help = "a // b" ]]'),
        [["@Volume", "marker"], ["@varying", "marker"], ["VolumeAttributes", "type"], ["string", "type"], ['"a // b"', "string"]]);
    assert.deepEqual(kinds("if (returned) return infloat;"), [["if", "keyword"], ["return", "keyword"]]);
});

test("comments go over lines", () => {
    const lines = ["a /* one", "two */ float b; /* x */ /**/", "c // /* no", "d", '"/*" /*/', "still", "*/ e"];
    assert.deepEqual(commentStarts(lines), [false, true, false, false, false, true, true]);
    assert.deepEqual(commentStarts(["/* one", "   two */", "import a;", "b /* c */;"]), [false, true, false, false], "nothing follows its end");
    assert.deepEqual(kinds(lines[1], true).slice(0, 2), [["two */", "comment"], ["float", "type"]]);
});

test("what is typed soon after each other is one step, what the graph does one of its own", () => {
    const history = new TextHistory("a");
    for (const [text, at] of [["ab", 0], ["abc", 300], ["abcd", 900], ["abcde", 3000]]) history.record(text, at);
    history.record("graph");
    history.record("graph!", 3200);
    assert.deepEqual([history.undo(), history.undo(), history.undo(), history.undo(), history.undo()], ["graph", "abcde", "abcd", "a", null]);
    assert.deepEqual([history.redo(), history.redo()], ["abcd", "abcde"]);
    history.record("other");
    assert.equal(history.redo(), null, "what was undone is gone once something else is done");
    assert.equal(history.undo(), "abcde");
});

test("several edits become one step, and the oldest are forgotten", () => {
    const history = new TextHistory("0");
    history.record("1");
    const { depth } = history;
    for (const text of ["2", "3", "4"]) history.record(text);
    history.joinSince(depth);
    assert.deepEqual([history.undo(), history.undo(), history.undo()], ["1", "0", null]);
    for (let i = 0; i < 2000; ++i) history.record(`x${i}`);
    assert.ok(history.depth <= 500);
    const long = new TextHistory("");
    for (let i = 0; i < 30; ++i) long.record(String(i).padStart(1 << 20, "x"));
    assert.ok(long.depth <= 16 && long.canUndo);
});

test("the caret goes to the end of a change", () => {
    assert.equal(endOfChange("float a = 1;", "float a = 25;"), "float a = 25".length);
    assert.equal(endOfChange("abc", "abc"), 0);
    assert.equal(endOfChange("aa", "a"), 0);
});

test("Enter keeps the indentation, and goes in after a brace", () => {
    assert.equal(marked(newline(chosen("    a;|"))), "    a;\n    |");
    assert.equal(marked(newline(chosen("    if (x) {|"))), "    if (x) {\n        |");
    assert.equal(marked(newline(chosen("  {|}"))), "  {\n      |\n  }");
    assert.equal(marked(newline(chosen("ab|cd|ef"))), "ab\n|ef");
    assert.equal(marked(closing(chosen("{\n        |"))), "{\n    }|");
    assert.equal(marked(closing(chosen("a = {1|"))), "a = {1}|");
});

test("Tab moves to the next stop, or all lines that are chosen", () => {
    assert.equal(marked(indent(chosen("ab|c"))), "ab  |c");
    assert.equal(marked(indent(chosen("|a\n\n  b\n|c"))), "|    a\n\n      b|\nc");
    assert.equal(marked(outdent(chosen("|    a\n\n      b|\nc"))), "|a\n\n  b|\nc");
    assert.equal(marked(outdent(chosen("      a|"))), "  a|");
    assert.equal(marked(outdent(chosen("  |a"))), "|a");
    assert.equal(marked(outdent(chosen("|a"))), "|a");
});

test("comments are made, and taken away", () => {
    const made = comment(chosen("  |a;\n    b;\n\n|c;"));
    assert.equal(made.text, "  // a;\n  //   b;\n\nc;");
    assert.equal(comment({ ...made }).text, "  a;\n    b;\n\nc;");
    assert.equal(comment(chosen("a|b")).text, "// ab");
});

test("snippets choose their first name", () => {
    const made = fromSnippet("for (int ${1:i} = 0; ${1:i} < ${2:4}; ++${1:i}) {\n    $0\n}", "    ");
    assert.equal(made.text, "for (int i = 0; i < 4; ++i) {\n        \n    }");
    assert.equal(made.text.slice(made.begin, made.end), "i");
    assert.equal(marked(fromSnippet("@uniform {\n    $0\n}")), "@uniform {\n    |\n}");
    assert.equal(marked(fromSnippet("plain")), "plain|");
});

test("names that begin with what is typed come first", () => {
    const items = [{ label: "saturate", sortText: "3saturate" }, { label: "tint", sortText: "1tint" }, { label: "@Volume", sortText: "0" }, { label: "t", sortText: "1t" }, { label: "mc", sortText: "1" }];
    assert.deepEqual(fitting(items, "t").map((one) => one.label), ["t", "tint", "saturate"]);
    assert.deepEqual(fitting(items, "vol").map((one) => one.label), ["@Volume"]);
    assert.equal(wordBefore("a.vox + 3", 5), "vox");
    assert.equal(wordBefore("1.", 2), "");
    assert.equal(plain("```openfl\nfloat t\n```\n**read** `x`"), "float t\nread x");
});

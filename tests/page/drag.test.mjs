// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What follows a hand: values that are sent one after the other, the last of those that wait, and the text that is tried.

import assert from "node:assert/strict";
import test from "node:test";

import { GraphDrag } from "../../tools/viewer/page/graph_drag.js";
import { Paced } from "../../tools/viewer/page/paced.js";

const turn = () => new Promise((resolve) => setImmediate(resolve));

test("the next value waits until the one before is shown, and is the last one", async (t) => {
    t.mock.timers.enable({ apis: ["setTimeout"] });
    const sent = [];
    const paced = new Paced(async (values) => { sent.push([...values]); return 5 + sent.length; });
    paced.put("a", 1);
    paced.put("a", 2);
    paced.put("a", 3);
    paced.put("b", 7);
    assert.deepEqual(sent, [[["a", 1]]]);
    assert.ok(paced.has("b"));
    await turn();
    paced.showState({ change: 5, phase: "done" });       // of before
    paced.showState({ change: 6, phase: "printing" });
    assert.equal(sent.length, 1);
    paced.showState({ change: 7, phase: "done" });
    assert.deepEqual(sent[1], [["a", 3], ["b", 7]]);
    await turn();
    paced.put("a", 4);
    t.mock.timers.tick(600);                             // a print that takes long gives way
    assert.deepEqual(sent[2], [["a", 4]]);
    await turn();
    paced.put("a", 5);
    paced.drop();
    paced.showState({ change: 99, phase: "failed" });
    assert.equal(sent.length, 3);
    paced.put("a", 6);
    assert.deepEqual(sent[3], [["a", 6]]);
    t.mock.timers.reset();
});

test("a number that is dragged is tried as a uniform of a text that is made once", async () => {
    const asked = [];
    let change = 0;
    const drag = new GraphDrag(async (path, more) => {
        asked.push([path, more]);
        if (path === "api/edit") return { text: "T", graph: { uniforms: [{ fablet: "A", name: "amount" }, { fablet: "B", name: "x" }, { fablet: "A", name: "amount2" }] } };
        return { change: ++change };
    });
    drag.put(1);                                         // nothing is held
    drag.begin({ action: { do: "expose", node: 1, port: 2 }, fablet: "A", known: ["amount"] });
    drag.put(0.5);
    await turn();
    assert.deepEqual(asked, [["api/edit", { action: { do: "expose", node: 1, port: 2 } }], ["api/try", { text: "T", uniform: "amount2", name: "A", value: 0.5 }]]);
    drag.showState({ change: 1, phase: "done" });
    drag.put(0.75);
    await turn();
    assert.equal(asked.length, 3);
    assert.equal(asked[2][1].value, 0.75);
    await drag.end(Promise.resolve(true));
    assert.equal(asked.length, 3);
    drag.begin({ action: {}, fablet: "A", known: ["amount"] });
    drag.showState({ change: 2, phase: "done" });
    drag.put(2);
    await turn();
    await drag.end(false);
    assert.equal(asked.at(-1)[0], "api/untry", "the text does not have the value");
    // What cannot be tried is told when it is let go.
    const refused = new GraphDrag(async () => { throw new Error("no"); });
    refused.begin({ action: {}, fablet: "A", known: [] });
    refused.put(1);
    await turn();
    await refused.end(Promise.resolve(undefined));
});

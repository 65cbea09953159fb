#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Checks the page of `openfab view` with axe-core, and how smoothly nodes of a large graph are dragged, in headless Chromium.
Set up and run it like view.py; for axe-core, `npm install --prefix out/browser axe-core` before."""

import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from harness import FABLET, WORLD, Page, Viewer, check, run_with_browser  # noqa: E402

FINDINGS = """async () => (await axe.run()).violations.filter((one) => ["serious", "critical"].includes(one.impact))
    .map((one) => `${one.id}: ${one.nodes[0].html.slice(0, 120)}`)"""

# How long frames take while a node is dragged by pointer events, as a hand makes them, between two frames.
REST = """async () => {
    const times = [];
    let last = performance.now();
    for (let i = 0; i < 120; ++i) {
        await new Promise(requestAnimationFrame);
        const now = performance.now();
        times.push(now - last);
        last = now;
    }
    return times.sort((a, b) => a - b);
}"""
FRAMES = """async (id) => {
    const root = document.getElementById("graph_svg"), head = document.querySelector(`#graph_svg [data-node="${id}"] .head`);
    const box = head.getBoundingClientRect();
    const send = (kind, x, y) => root.dispatchEvent(new PointerEvent(kind, { pointerId: 1, button: kind === "pointermove" ? -1 : 0, buttons: 1, clientX: x, clientY: y, bubbles: true, cancelable: true }));
    root.setPointerCapture = () => {};
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    send("pointerdown", x, y);
    const times = [];
    let last = performance.now();
    for (let i = 0; i < 120; ++i) {
        for (let k = 0; k < 3; ++k) send("pointermove", x + 90 * Math.sin(i / 9 + k / 27), y + 60 * Math.cos(i / 7 + k / 21) - 60);
        await new Promise(requestAnimationFrame);
        const now = performance.now();
        times.push(now - last);
        last = now;
    }
    send("pointerup", x, y);
    return times.sort((a, b) => a - b);
}"""


def look(browser, options, url, axe):
    for scheme, size in (("light", (1440, 900)), ("dark", (1440, 900)), ("light", (900, 800)), ("dark", (900, 800)), ("light", (400, 800)), ("dark", (400, 800))):
        at = Page(browser, options, scheme=scheme, size=size)
        at.open(url)
        page = at.page
        page.evaluate(axe)

        def clean(what, page=page, scheme=scheme, size=size):
            found = page.evaluate(FINDINGS)
            check(f"{what}, {scheme}, {size[0]} px: nothing serious {found}", not found)

        clean("the part")
        page.click("#text_button")
        page.click("#graph_button")
        page.wait_for_selector("#graph_svg .node")
        at.settle(600)
        clean("graph and text")
        if size[0] > 900:
            gap = page.evaluate("document.getElementById('stage').getBoundingClientRect().left - document.getElementById('live').getBoundingClientRect().right")
            check(f"{size[0]} px: the picture stands beside the panel, whatever the text's lines take: {gap:.0f} px", abs(gap) < 2)
        page.click("#graph_add")
        page.wait_for_selector("#palette_list .tile")
        clean("categories")
        page.click("#palette_list .tile")
        at.settle(400)
        clean("entries")
        check(f"{size[0]} px: nothing is wider than the window", page.evaluate("document.documentElement.scrollWidth <= innerWidth"))
        small = page.evaluate("""() => [...document.querySelectorAll("#graph_svg text")].filter((one) => {
            const box = one.getBoundingClientRect(), scale = one.getScreenCTM().a;
            return box.width > 0 && parseFloat(getComputedStyle(one).fontSize) * scale < 9.99;
        }).length""")
        check(f"{size[0]} px: no letters of the graph are below 10 px", small == 0)
        at.close()


def drag(browser, options, folder):
    lines = "".join(f"        float v{i} = sin(v{i - 1}) + {i};\n" for i in range(1, 150))
    (folder / "ball.fl").write_text(FABLET.replace("        mc.Set(core", f"        float v0 = t;\n{lines}        mc.Set(core", 1))
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        at.open(url)
        page.click("#graph_button")
        page.wait_for_function("() => document.querySelectorAll('#graph_svg .node').length > 290", polling=50)
        page.wait_for_selector("#progress", state="hidden")
        at.settle(4000)
        for what, key in (("as it opens", None), ("all of it in view", "0")):
            if key:
                page.focus("#graph_svg")
                page.keyboard.press(key)
                at.settle(800)
            node = page.evaluate("""() => [...document.querySelectorAll("#graph_svg .node.operator, #graph_svg .node.call")].find((one) => { const b = one.querySelector(".head").getBoundingClientRect(), r = document.getElementById("graph_svg").getBoundingClientRect();
                const hit = document.elementFromPoint(b.x + b.width / 2, b.y + b.height / 2); return b.x > r.x && b.right < r.right && b.y > r.y && b.bottom < r.bottom && one.contains(hit); })?.dataset.node""")
            rest, times = page.evaluate(REST), page.evaluate(FRAMES, node)
            at_rest, within = (one[int(0.95 * len(one))] for one in (rest, times))
            print(f"        {what}: median {times[len(times) // 2]:.1f} ms, 95 % below {within:.1f} ms (at rest {at_rest:.1f} ms), the longest {times[-1]:.1f} ms")
            # On a busy machine frames take longer at rest, too.
            check(f"{what}, frames of a drag are short", within < max(33, 1.2 * at_rest))
        at.eventually("and the place is kept", lambda: (folder / "ball.graph.json").is_file())
        at.close()


def main(browser, options):
    folder = options.out / "access_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    script = options.out / "node_modules/axe-core/axe.min.js"
    if script.is_file():
        with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
            look(browser, options, url, script.read_text())
    else:
        print(f"skipped axe-core, which is not at {script}")
    drag(browser, options, folder)


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)

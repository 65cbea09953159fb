#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""How soon the page of `openfab view` shows something, in headless Chromium: a solid after opening a world whose kernels are known,
and the answers to sliders, to the graph and to changed text. A busy machine is slower, as it is at a task of its own that is
measured beside: bounds grow with it. Set up and run it like view.py."""

import json
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from harness import FABLET, WORLD, Page, Viewer, check, run_with_browser  # noqa: E402

# When the canvas of the volume first had more than a ground on it, since the page was asked for.
WATCH = """
const seen = (canvas) => {
    if (!canvas?.width || canvas.hidden) return false;
    const small = new OffscreenCanvas(32, 32), pen = small.getContext("2d", { willReadFrequently: true });
    pen.drawImage(canvas, 0, 0, 32, 32);
    const data = pen.getImageData(0, 0, 32, 32).data;
    let solid = 0;
    for (let i = 3; i < data.length; i += 4) solid += data[i] > 128;
    return solid > 40;
};
window.marks = {};
const look = () => {
    if (!("solid" in marks) && seen(document.getElementById("volume"))) marks.solid = performance.now();
    if (!("solid" in marks)) requestAnimationFrame(look);
};
addEventListener("DOMContentLoaded", () => { marks.loaded = performance.now(); look(); });
"""


def slowness():
    """How many times as long as on a core of its own a task takes now."""
    begin, used = time.monotonic(), time.process_time()
    while time.process_time() - used < 0.3:
        sum(range(1000))
    return max(1.0, (time.monotonic() - begin) / (time.process_time() - used))


def check_median(what, times, bound_ms):
    """`times`: milliseconds, and how slow the machine was then. Twice the bound is for what else a browser does without a GPU."""
    alone = statistics.median(ms / slow for ms, slow in times)
    print(f"        {what}: {[round(ms) for ms, _ in times]} ms on a machine {statistics.median(slow for _, slow in times):.1f} times as slow as alone")
    check(f"{what}: {alone:.0f} ms of a machine of its own are below {bound_ms} ms", alone < bound_ms)


def opening(browser, options):
    world = pathlib.Path(__file__).parents[2] / "gallery/marble_table/table.fab.json"
    found = []
    for i in range(4):  # the first compiles
        slow = slowness()
        begin = time.monotonic()
        with Viewer(options, world, "--watch") as url:
            started = 1000 * (time.monotonic() - begin)
            at = Page(browser, options, size=(1440, 900))
            page = at.page
            page.add_init_script(WATCH)
            page.goto(url)
            page.wait_for_function("() => 'solid' in marks", polling=50, timeout=120_000)
            marks = page.evaluate("marks")
            print(f"        {'cold' if i == 0 else 'warm'}: the command answers after {started:.0f} ms, the page is read after {marks['loaded']:.0f} ms, a solid is seen after {marks['solid']:.0f} ms")
            if i:
                found.append((started + marks["solid"], slow))
            else:
                at.settle(15000)  # what culling needs is compiled behind the picture
                at.shot("speed_table")
            at.close()
    check_median("from the command to a solid, warm", found, 1500)


# What one waits for after a move of a slider, a click, a change: the next frame in which the page is otherwise.
def answer(page, does, shows):
    return page.evaluate("""() => new Promise((done, failed) => {
        const shown = () => %s, before = shown(), begin = performance.now();
        %s;
        const look = () => {
            if (shown() !== before) done(performance.now() - begin);
            else if (performance.now() - begin > 30000) failed(new Error("nothing changes"));
            else requestAnimationFrame(look);
        };
        requestAnimationFrame(look);
    })""" % (shows, does))


def answers(browser, options):
    folder = options.out / "speed_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "4") as url:
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        at.open(url)
        at.settle(4000)

        def times(does, shows, n=7, between=400):
            found = []
            for i in range(n):
                slow = slowness()
                found.append((answer(page, does.replace("$i", str(i)), shows), slow))
                at.settle(between)
            return found[1:]

        picture = "document.getElementById('plane').toDataURL()"
        check_median("a slider of slices, to its picture", times("const s = document.getElementById('slider'); s.value = 20 + 3 * $i; s.dispatchEvent(new Event('input', { bubbles: true }))", picture), 100)
        check_median("a slider of a uniform, to its number", times("const s = document.querySelector('#uniforms input[type=range]'); s.value = 0.5 + 0.2 * $i; s.dispatchEvent(new Event('input', { bubbles: true }))", "document.querySelector('#uniforms input[type=number]').value", between=1500), 100)
        check_median("and to its picture", times("const s = document.querySelector('#uniforms input[type=range]'); s.value = 0.6 + 0.25 * $i; s.dispatchEvent(new Event('input', { bubbles: true }))", picture, between=2500), 500)
        page.click("#graph_button")
        page.wait_for_selector("#graph_svg .node")
        at.settle(3000)
        check_median("a node, to what goes into it", times("const n = document.querySelectorAll('#graph_svg .node'); document.getElementById('graph_svg').dispatchEvent(new KeyboardEvent('keydown', { key: $i % 2 ? 'ArrowLeft' : 'ArrowRight', bubbles: true }))", "document.getElementById('inspector').innerHTML"), 100)
        check_median("an edit of the graph, to the text", times("const f = [...document.querySelectorAll('#inspector [data-control^=port]')].at(-1); f.value = f.value.startsWith('0.5') ? '0.75' : '0.5'; f.dispatchEvent(new Event('change'))", "document.getElementById('source').value", between=3000) if page.evaluate("""() => {
            const root = document.getElementById("graph_svg"), node = document.querySelector("#graph_svg .node[aria-label*='smoothstep'] .head"), b = node.getBoundingClientRect();
            for (const kind of ["pointerdown", "pointerup"]) root.dispatchEvent(new PointerEvent(kind, { pointerId: 1, button: 0, clientX: b.x + b.width / 2, clientY: b.y + b.height / 2, bubbles: true }));
            return document.querySelectorAll("#inspector [data-control^=port]").length > 0; }""") else [(1e9, 1)], 100)

        # Changed text: beside what the compiler and the print take by themselves, of a text that is as new.
        found = []
        for i in range(4):
            new = f"sin((rings + {i + time.time_ns() % 1000003 * 1e-6:.6f}) * attr"
            other = folder / "other"
            other.mkdir(exist_ok=True)
            (other / "ball.fl").write_text(FABLET.replace("sin(rings * attr", new.replace("rings +", "rings -")))
            (other / "ball.fab.json").write_text(WORLD)
            slow = slowness()
            begin = time.monotonic()
            subprocess.run([options.bin / "openflc", "run", other / "ball.fl", other / "ball.fab.json", "--draft=4", f"--output={other}/ball.ofr", "--progress=none"], check=True, capture_output=True)
            alone = 1000 * (time.monotonic() - begin)
            text = FABLET.replace("sin(rings * attr", new)
            waited = answer(page, f"const s = document.getElementById('source'); s.value = {json.dumps(text)}; s.dispatchEvent(new Event('input', {{ bubbles: true }})); document.getElementById('save').click()", picture)
            print(f"        changed text: {waited:.0f} ms to its picture; compiled and printed by itself: {alone:.0f} ms")
            if i:
                found.append((max(0, waited - alone), slow))
            at.settle(3000)
        check_median("changed text, to its picture beside compiling and printing", found, 300)
        at.close()


def main(browser, options):
    opening(browser, options)
    answers(browser, options)


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)

#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The page of `openfab view` under fingers, in a window of 400 px of headless Chromium, which makes touches of its own: taps, a
long press, drags and pinches, in the graph and in the picture. Set up and run it like view.py."""

import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import text  # noqa: E402
from harness import FABLET, WORLD, Page, Viewer, check, middle, run_with_browser  # noqa: E402


class Fingers:
    """Touches as the browser gets them from a screen, so that scrolling, clicks and menus are its own."""

    def __init__(self, page):
        self.page = page
        self.session = page.context.new_cdp_session(page)

    def send(self, kind, *points):
        self.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]})

    def tap(self, x, y):
        self.send("touchStart", (x, y))
        self.send("touchEnd")
        self.page.wait_for_timeout(400)

    def press(self, x, y, ms=1200):
        self.send("touchStart", (x, y))
        self.page.wait_for_timeout(ms)
        self.send("touchEnd")
        self.page.wait_for_timeout(400)

    def drag(self, begin, end, steps=8):
        """Each finger goes from its place of `begin` to that of `end`."""
        self.send("touchStart", *begin)
        for i in range(1, steps + 1):
            self.send("touchMove", *[(a[0] + (b[0] - a[0]) * i / steps, a[1] + (b[1] - a[1]) * i / steps) for a, b in zip(begin, end)])
            self.page.wait_for_timeout(30)
        self.send("touchEnd")
        self.page.wait_for_timeout(500)


VIEW = """() => { const m = new DOMMatrix(document.querySelector("#graph_svg > svg").style.transform); return { x: m.e, y: m.f, scale: m.a }; }"""
# A place of the ground of the graph, away from nodes.
GROUND = """() => {
    const box = document.getElementById("graph_svg").getBoundingClientRect();
    for (let y = box.y + 40; y < Math.min(box.bottom, innerHeight) - 40; y += 20) for (let x = box.x + 40; x < box.right - 40; x += 20) {
        const free = [[0, 0], [30, 0], [-30, 0], [0, 30], [0, -30]].every(([dx, dy]) => !document.elementFromPoint(x + dx, y + dy)?.closest("[data-node], [data-frame], #graph_map") && document.elementFromPoint(x + dx, y + dy)?.closest("#graph_svg"));
        if (free) return [x, y];
    }
    return null;
}"""


def seen(page):
    """A node the middle of whose head is in view: its number and that place."""
    return page.evaluate("""() => { for (const one of document.querySelectorAll("#graph_svg .node")) {
        const b = one.querySelector(".head").getBoundingClientRect(), x = b.x + b.width / 2, y = b.y + b.height / 2;
        if (one.contains(document.elementFromPoint(x, y))) return [Number(one.dataset.node), x, y];
    } return null; }""")


def graph(at, fingers):
    page = at.page
    fingers.tap(*middle(page, "#graph_button"))
    page.wait_for_selector("#graph_svg .node")
    at.settle(1000)
    check("a tap opens the graph, at the top of the window", 0 <= page.locator("#graph").bounding_box()["y"] < 60)

    id, x, y = seen(page)
    fingers.tap(x, y)
    check("a tap chooses a node", page.get_attribute(f"#graph_svg [data-node='{id}'].node", "aria-current") == "true")
    check("and shows what goes into it", page.locator("#inspector h3").count() == 1)

    scrolled = page.evaluate("scrollY")
    ground = page.evaluate(GROUND)
    before = page.evaluate(VIEW)
    fingers.drag([ground], [(ground[0] + 60, ground[1] + 25)])
    after = page.evaluate(VIEW)
    check(f"a drag of the ground moves the graph: {after['x'] - before['x']:.0f}, {after['y'] - before['y']:.0f} px", abs(after["x"] - before["x"] - 60) < 8 and abs(after["y"] - before["y"] - 25) < 8)
    check("not the page", page.evaluate("scrollY") == scrolled and 0 <= page.locator("#graph").bounding_box()["y"] < 60)

    box = page.locator("#graph_svg").bounding_box()
    cx, cy = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = page.evaluate(VIEW)
    fingers.drag([(cx - 40, cy), (cx + 40, cy)], [(cx - 80, cy), (cx + 80, cy)])
    after = page.evaluate(VIEW)
    check(f"two fingers zoom it, by {after['scale'] / before['scale']:.2f}", 1.8 < after["scale"] / before["scale"] < 2.2)
    check("about what is between them", abs((cx - box["x"] - after["x"]) / after["scale"] - (cx - box["x"] - before["x"]) / before["scale"]) < 6 / before["scale"])
    fingers.drag([(cx - 80, cy), (cx + 80, cy)], [(cx - 40, cy), (cx + 40, cy)])
    check("and back", abs(page.evaluate(VIEW)["scale"] / before["scale"] - 1) < 0.1)
    check("the page is not zoomed by it", page.evaluate("visualViewport.scale") == 1)

    id, x, y = seen(page)
    fingers.drag([(x, y)], [(x + 20, y + 45)])
    now = page.evaluate("(id) => { const b = document.querySelector(`#graph_svg [data-node='${id}'].node .head`).getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }", id)
    check(f"a drag of a node moves it: {now[0] - x:.0f}, {now[1] - y:.0f} px", abs(now[0] - x - 20) < 8 and abs(now[1] - y - 45) < 8)

    ground = page.evaluate(GROUND)
    fingers.press(*ground)
    check("a long press of the ground opens the list", page.is_visible("#palette"))
    page.wait_for_selector("#palette_list .tile")
    fingers.tap(*middle(page, "#palette_list .tile:has(b:text-is('Lattices'))"))
    page.wait_for_selector("#palette_list .entry")
    y = page.evaluate("document.getElementById('palette_list').scrollTop")
    lx, ly = middle(page, "#palette_list")
    fingers.drag([(lx, ly + 100)], [(lx, ly - 100)])
    check("a drag of the list scrolls it", page.evaluate("document.getElementById('palette_list').scrollTop") > y + 50)
    before = text(page)
    at.settle(1000)
    page.locator("#palette_list .entry:has(b:text-is('gyroid'))").first.scroll_into_view_if_needed()
    fingers.tap(*middle(page, "#palette_list .entry:has(b:text-is('gyroid'))"))
    at.eventually("a tap takes an entry", lambda: text(page) != before and "gyroid" in text(page))
    page.wait_for_function("() => !document.body.classList.contains('graph_busy')")
    at.settle(600)
    check("and closes it", not page.is_visible("#palette"))

    # A wire, from the dot of an output to an input.
    fingers.tap(*middle(page, "#graph_fit")) if page.locator("#graph_fit").bounding_box()["x"] < 380 else page.evaluate("document.getElementById('graph_fit').click()")
    at.settle(600)
    ends = page.evaluate("""() => {
        const at = (one) => { const b = one.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; };
        const hit = (one) => { const [x, y] = at(one); return document.elementFromPoint(x, y) === one; };
        for (const output of document.querySelectorAll("#graph_svg .node[aria-label*='gyroid'] .out")) {
            const input = [...document.querySelectorAll("#graph_svg .node[aria-label*='smoothstep'] .in")].find(hit);
            if (input && hit(output)) return [at(output), at(input)];
        }
        return null;
    }""")
    check(f"the ends of a wire are in view {ends}", bool(ends))
    if ends:
        before = text(page)
        fingers.drag([ends[0]], [ends[1]])
        at.eventually("a drag from a dot to an input is a wire", lambda: "smoothstep(gyroid" in text(page))
        check("it was none before", "smoothstep(gyroid" not in before)
    at.shot("touch_graph")


def picture(at, fingers):
    page = at.page
    fingers.tap(*middle(page, "#graph_button"))
    page.evaluate("scrollTo(0, 0)")
    page.keyboard.press("4")
    at.settle(2500)
    x, y = middle(page, "#volume")
    before = page.url
    fingers.drag([(x, y)], [(x + 60, y)])
    at.settle(600)
    check("a drag turns the volume", page.url != before and page.evaluate("scrollY") == 0)
    zoom = at.text("#zoom")
    fingers.drag([(x - 30, y), (x + 30, y)], [(x - 60, y), (x + 60, y)])
    check(f"two fingers zoom it: {zoom}, {at.text('#zoom')}", float(at.text("#zoom").split()[0]) > 1.5 * float(zoom.split()[0]))
    page.keyboard.press("1")
    at.settle(1500)
    x, y = middle(page, "#plane")
    zoom = at.text("#zoom")
    fingers.drag([(x - 30, y), (x + 30, y)], [(x - 60, y), (x + 60, y)])
    check(f"and a slice: {zoom}, {at.text('#zoom')}", float(at.text("#zoom").split()[0]) > 1.5 * float(zoom.split()[0]))
    fingers.tap(x, y)
    at.eventually("a tap picks a voxel", lambda: page.locator("#pick dt").count() > 1)
    page.evaluate("scrollTo(0, 0)")
    fingers.drag([(200, 700)], [(200, 300)])
    check("a drag beside the picture scrolls the page", page.evaluate("scrollY") > 100)
    check("nothing is wider than the window", page.evaluate("document.documentElement.scrollWidth <= innerWidth"))


def main(browser, options):
    folder = options.out / "touch_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options, size=(400, 800), touch=True)
        at.open(url)
        fingers = Fingers(at.page)
        graph(at, fingers)
        picture(at, fingers)
        at.close()


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)

#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The steps of newcomer.py by keyboard alone, each key counted, in headless Chromium; then where Tab and F6 go, whether one sees
it, and what Escape ends. Set up and run it like view.py."""

import pathlib
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import text  # noqa: E402
from harness import FABLET, WORLD, Page, Viewer, check, run_with_browser  # noqa: E402
from newcomer import OCTAHEDRON, Actions, bitmap, ready  # noqa: E402

# What has the focus: the part of the page, a name, and whether one sees both it and that it has the focus.
FOCUS = """() => {
    const one = document.activeElement;
    if (!one || one === document.body) return null;
    const box = one.getBoundingClientRect(), style = getComputedStyle(one), editor = one.id === "source" && getComputedStyle(document.getElementById("editor"));
    const ring = (of) => of.outlineStyle !== "none" && parseFloat(of.outlineWidth) >= 2;
    const middle = document.elementFromPoint(Math.min(Math.max(box.x + box.width / 2, 0), innerWidth - 1), Math.min(Math.max(box.y + box.height / 2, 0), innerHeight - 1));
    return {
        part: one.closest("header, #live, #stage, #text, #graph, #details")?.id || "header",
        name: one.getAttribute("aria-label") || one.id || one.textContent.trim().slice(0, 30),
        group: one.closest("[role=radiogroup], [role=tablist], #clips, #standpoints, #palette_list")?.getAttribute("aria-label") ?? null,
        ring: ring(style) || Boolean(editor && ring(editor)),
        seen: box.width > 0 && box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth && (one === middle || one.contains(middle) || middle?.contains(one) || one.type === "color"),
        again: one === window.firstStop,
    };
}"""


class Keys:
    """Keys of a keyboard, counted; a file is chosen in the dialog of the system, once more by its keyboard."""

    def __init__(self, page, act):
        self.page, self.act, self.dialogs = page, act, []
        page.on("filechooser", lambda dialog: self.dialogs.append(dialog))

    def __call__(self, what, *keys):
        for key in keys:
            self.act(f"{key:12} {what}", lambda key=key: self.page.keyboard.press(key))

    def choose(self, path):
        self("a file's dialog", "o")
        for _ in range(100):
            if self.dialogs:
                break
            self.page.wait_for_timeout(200)
        self.act(f"choose {path.name}", lambda: self.dialogs.pop().set_files(path))


def focus_name(page):
    return (page.evaluate(FOCUS) or {}).get("name")


def take(at, keys, category, name):
    """A function from the list: by the letter its category begins with, then by that of its name."""
    page = at.page
    keys("the list", "a")
    page.wait_for_selector("#palette_list .tile")
    keys("its categories", "ArrowDown")
    for wanted in (category, name):
        for _ in range(20):
            if page.evaluate("document.activeElement.querySelector('b')?.textContent") == wanted:
                break
            keys(f"on to {wanted}", wanted[0])
        keys(f"take {wanted}", "Enter")
    ready(at)


def chosen(page):
    return page.evaluate("document.getElementById(document.getElementById('graph_svg').getAttribute('aria-activedescendant'))?.getAttribute('aria-label') ?? ''")


def walk_to(page, keys, wanted, *ways):
    """Arrows to a node, as its reader is told which one is chosen."""
    for way in ways:
        if wanted in chosen(page):
            break
        keys(f"to {wanted}", way)
    check(f"arrows come to {wanted}: {chosen(page)}", wanted in chosen(page))


def walk(browser, options):
    folder = options.out / "keyboard"
    shutil.rmtree(folder, ignore_errors=True)
    mesh, picture = options.out / "octahedron.obj", options.out / "spots.bmp"
    mesh.write_text(OCTAHEDRON)
    picture.write_bytes(bitmap(32, 16, lambda x, y: (x // 4 + y // 4) % 2 == 0))
    act = Actions()
    with act("openfab view --new", lambda: Viewer(options, "--new", folder)) as url:
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        keys = Keys(page, act)
        act("open the page", lambda: at.open(url, view=None))
        keys.choose(mesh)
        at.eventually("the mesh is the object's", lambda: "is the mesh octahedron" in at.text("#files_note"))
        keys("the part", "p")
        check("which is its printer", focus_name(page) == "Printer")
        for _ in range(12):
            if page.eval_on_selector("[data-control=printer]", "one => one.value") == "j850":
                break
            keys("J850", "ArrowDown")
        at.eventually("the world has the printer", lambda: '"printer": "j850"' in (folder / "keyboard.fab.json").read_text())
        at.eventually("and the focus stays", lambda: focus_name(page) == "Printer")
        keys("60 mm", "Tab", "6", "0", "Enter")
        at.eventually("it is 60 mm wide", lambda: "60 × 60 × 60" in at.text("#part"))
        keys("out of the field", "Escape")
        keys("the graph", "g")
        page.wait_for_selector("#graph_svg .node")
        at.settle(500)
        take(at, keys, "Lattices", "gyroid")
        take(at, keys, "Materials", "mix_field")
        at.settle(400)
        walk_to(page, keys, "= gyroid", "ArrowUp", "ArrowUp", "ArrowLeft", "ArrowDown", "ArrowDown")
        keys("a wire to the field", "w")
        for way in ("ArrowDown", "ArrowDown", "ArrowDown", "ArrowUp"):
            if "to field of" in at.text("#graph_message"):
                break
            keys("to the field", way)
        keys("it is put there", "Enter")
        ready(at)
        at.eventually("the wire is in the text", lambda: re.search(r"mix_field\(core, shell, gyroid_value", text(page)))
        check("the node that it came to is chosen", "mix_field" in chosen(page))
        keys("a wire to the result", "w", "Enter")
        ready(at)
        at.eventually("which is the result", lambda: re.search(r"return \w+;", text(page)) and "return" in chosen(page))
        keys("its input", "i")
        take(at, keys, "Materials", "mix_depth")
        at.eventually("a colour by depth lies over it", lambda: re.search(r"return mix_depth\(core, \w+, distance\(", text(page)))
        at.shot("keyboard_graph")
        keys.choose(picture)
        at.eventually("the picture can be put on", lambda: focus_name(page) == "Put it on")
        keys("put it on", "Enter")
        at.eventually("it is on the part", lambda: "mix_picture_on(" in (folder / "keyboard.fl").read_text() and '"picture": "spots"' in (folder / "keyboard.fab.json").read_text())
        at.settle(1500)
        at.eventually("it is printed as a draft", lambda: not page.is_visible("#progress"))
        keys("print", "Control+p")
        page.wait_for_function("() => document.getElementById('print_state').textContent.includes('is printed')", timeout=600_000)
        at.eventually("it is in view, with its path", lambda: at.text("#title") == "keyboard.ofr" and at.text("#printed_path") == str(folder / "keyboard.ofr"))
        keys("back to the picture", "Escape")
        keys("without the graph", "g")
        at.settle(4000)
        check("it is seen", at.colors("#volume") > 30 and not page.is_visible("#graph"))
        at.shot("keyboard_printed")
        print(f"        {act.count} keys")
        check(f"{act.count} actions are at most 60", act.count <= 60)
        at.close()


def stops(page, key, most=200):
    """Where Tab comes to, until it leaves the page or is where it began."""
    found = []
    for _ in range(most):
        page.keyboard.press(key)
        now = page.evaluate(FOCUS)
        if now is None or (found and now["again"]):
            break
        if not found:
            page.evaluate("window.firstStop = document.activeElement")
        found.append(now)
    return found


def focus(browser, options):
    folder = options.out / "focus_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        for scheme, size in (("light", (1440, 900)), ("dark", (900, 800)), ("light", (400, 800))):
            at = Page(browser, options, scheme=scheme, size=size)
            page = at.page
            at.open(url, view=None)
            page.keyboard.press("g")
            page.wait_for_selector("#graph_svg .node")
            at.settle(600)
            page.evaluate("document.body.tabIndex = -1; document.body.focus(); document.body.removeAttribute('tabindex')")
            found = stops(page, "Tab")
            what = f"{size[0]} px, {scheme}"
            unseen = [one["name"] for one in found if not one["seen"]]
            check(f"{what}: each stop of Tab is seen {unseen}", not unseen)
            bare = [one["name"] for one in found if not one["ring"]]
            check(f"{what}: and that it has the focus {bare}", not bare)
            parts = [one["part"] for i, one in enumerate(found) if i == 0 or found[i - 1]["part"] != one["part"]]
            wanted = ["header", "live", "stage", "graph", "details"] if size[0] > 900 else ["header", "stage", "graph", "live", "details"]
            check(f"{what}: Tab goes through the parts of the page as they stand {parts}", parts == wanted)
            groups = [one["group"] for one in found if one["group"]]
            check(f"{what}: a group is one stop {groups}", groups and len(groups) == len(set(groups)))
            back = stops(page, "Shift+Tab")
            check(f"{what}: and back through the same, {len(found)} and {len(back)}", abs(len(found) - len(back)) <= 1)
            at.close()
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        at.open(url)
        # F6, and arrows in a group.
        seen = []
        for _ in range(3):
            page.keyboard.press("F6")
            seen.append(page.evaluate(FOCUS)["part"])
        check(f"F6 goes from part to part {seen}", set(seen) == {"live", "stage", "details"})
        page.keyboard.press("Shift+F6")
        check("and back", page.evaluate(FOCUS)["part"] == seen[1])
        page.focus("[data-view=z]")
        page.keyboard.press("ArrowRight")
        check("an arrow goes to the next view", page.evaluate("document.activeElement.dataset.view") == "y" and page.get_attribute("[data-view=y]", "aria-checked") == "true")
        page.keyboard.press("ArrowLeft")
        before = page.input_value("#number")
        page.click("[data-view=z]")
        page.keyboard.press("ArrowUp")
        check("after a click arrows leaf through the slices", page.input_value("#number") != before)
        # Escape.
        page.focus("[data-control=nx0]")
        page.keyboard.type("7")
        page.keyboard.press("Escape")
        check("Escape leaves a field as it was", page.evaluate("document.activeElement.id") == "plane" and page.input_value("[data-control=nx0]") == "1" and "grid" not in (folder / "ball.fab.json").read_text())
        page.keyboard.press("g")
        page.wait_for_selector("#graph_svg .node")
        at.settle(500)
        page.keyboard.press("a")
        page.wait_for_selector("#palette_list .tile")
        page.keyboard.press("ArrowDown")
        page.keyboard.press("Tab")
        check("the list is one stop of Tab", page.evaluate("!document.getElementById('palette_list').contains(document.activeElement)"))
        page.keyboard.press("Shift+Tab")
        page.keyboard.press("Escape")
        check("Escape closes the list", not page.is_visible("#palette") and page.evaluate("document.activeElement.id") == "graph_svg")
        before = text(page)
        for _ in range(8):
            if "smoothstep" in chosen(page):
                break
            page.keyboard.press("ArrowLeft")
        page.keyboard.press("w")
        wired = at.text("#graph_message")
        page.keyboard.press("Escape")
        check(f"Escape lets a wire go: {wired}", "a wire to" in wired and at.text("#graph_message") == "" and text(page) == before)
        page.keyboard.press("Escape")
        check("and then chooses nothing", chosen(page) == "")
        page.keyboard.press("?")
        check("a key shows keys", page.is_visible("#help"))
        page.keyboard.press("Escape")
        check("and Escape ends that", not page.is_visible("#help"))
        at.close()


def hold_what_is_chosen(browser, options):
    """Arrows go on from what they chose, though what the page hears of the world is older."""
    folder = options.out / "held"
    shutil.rmtree(folder, ignore_errors=True)
    with Viewer(options, "--new", folder) as url:
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        at.open(url, view=None)
        printer = page.locator("[data-control=printer]")
        choices = printer.evaluate("one => [...one.options].map((option) => option.value)")
        first = choices.index(printer.input_value())
        late, given = [], []

        def answer(route):
            response = route.fetch()
            how = {"status": response.status, "headers": response.headers, "body": response.body()}
            if not given and (late or f'"printer":"{choices[first + 1]}"'.encode() in how["body"].replace(b" ", b"")):
                late.append((route, how))
            else:
                route.fulfill(**how)

        page.route("**/api/live", answer)
        printer.focus()
        page.keyboard.press("ArrowDown")
        at.eventually("the page asks for the world with the first", lambda: bool(late))
        page.keyboard.press("ArrowDown")
        route, how = late.pop(0)
        route.fulfill(**how)
        at.settle(400)
        check("an older answer takes nothing back", printer.input_value() == choices[first + 2])
        given.append(True)
        for route, how in late:
            route.fulfill(**how)
        page.keyboard.press("ArrowDown")
        at.eventually("arrows go on", lambda: f'"printer": "{choices[first + 3]}"' in (folder / "held.fab.json").read_text())
        at.eventually("and the field with them", lambda: printer.input_value() == choices[first + 3])
        at.close()


def main(browser, options):
    walk(browser, options)
    focus(browser, options)
    hold_what_is_chosen(browser, options)


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)

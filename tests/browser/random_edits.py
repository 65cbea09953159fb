#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Makes 200 random edits in the graph pane, with mouse and keyboard, in headless Chromium. Set up and run it like view.py. The
result must be a program that checks and prints like the same text outside of a page; values are compared with the same edit
made directly in the text. OPENFAB_SEED=N repeats a run."""

import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import drag, text  # noqa: E402
from harness import FABLET, WORLD, Page, Viewer, check, run_with_browser  # noqa: E402

kEdits = 200


# One question for what the walk may do next: the middles of what fits a selector, where the pointer reaches it.
FIND = """([selector, dice]) => {
    const found = [...document.querySelectorAll(selector)].map((one) => one.getBoundingClientRect()).filter((box) => box.width)
        .map((box) => [box.x + box.width / 2, box.y + box.height / 2]);
    return found.length ? found[Math.floor(dice * found.length)] : null;
}"""


def squeezed(source):
    """Returns a text without its layout, which the formatter determines."""
    return re.sub(r"\s+", "", source)


class Walk:
    def __init__(self, at, dice):
        self.at, self.page, self.dice = at, at.page, dice
        self.done, self.refused, self.compared = {}, 0, 0

    def choose(self, selector):
        return self.page.evaluate(FIND, [f"#graph_svg {selector}", self.dice.random()])

    def wait(self):
        """Waits for the answer: the pane is not busy, and it shows the text."""
        self.page.wait_for_function("() => !document.body.classList.contains('graph_busy')", polling=20)

    def click(self, selector):
        place = self.choose(selector)
        if place:
            self.page.mouse.click(*place)
        return place

    def value(self):
        """Changes a number in the inspector, and compares with the same edit in the text."""
        if not self.click(".node:has(.port circle.free.number) .head"):
            return
        fields = self.page.evaluate("() => [...document.querySelectorAll('#inspector .port_row input.value')].map((one) => [one.dataset.control, one.value])")
        plain = [one for one in fields if re.fullmatch(r"\d+(\.\d+)?", one[1])]
        if not plain:
            return
        control, old = self.dice.choice(plain)
        new = f"{self.dice.uniform(0.1, 3):.3g}"
        before = text(self.page)
        field = self.page.locator(f"#inspector [data-control={control}]")
        field.fill(new)
        field.press("Enter")
        self.wait()
        after = text(self.page)
        if after == before:
            return
        self.compared += 1
        places = re.finditer(rf"(?<![\w.]){re.escape(old)}(?![\w.])", before)
        by_hand = [squeezed(before[: m.start()] + new + before[m.end() :]) for m in places]
        if squeezed(after) not in by_hand:
            check(f"{old} became {new} as by hand:\n{before}\n{after}", False)

    def wire(self):
        start, end = self.choose(".node .out"), self.choose(".node .port .in")
        if start and end:
            drag(self.page, start, end)

    def pull_off(self):
        end = self.choose(".node .port .in:not(.free)")
        if end:
            box = self.page.locator("#graph_svg").bounding_box()
            drag(self.page, end, (box["x"] + 8, box["y"] + 8))

    def delete(self):
        if self.click(":is(.node.call, .node.operator, .node.value) .head"):
            self.page.keyboard.press("Delete")

    def add(self):
        self.page.focus("#graph_svg")
        self.page.keyboard.press("Escape")
        self.page.keyboard.press("a")
        self.page.wait_for_selector("#palette:not([hidden])")
        self.page.fill("#palette_search", self.dice.choice(["sin", "abs", "noise", "gyroid", "remap", "min", "+", "*", "smoothstep", "saturate"]))
        self.page.keyboard.press("Enter")

    def group(self):
        """Groups two nodes into a function; the page asks for its name."""
        first, second = self.choose(".node.call .head"), self.choose(".node.call .head")
        if first and second and first != second:
            self.page.mouse.click(*first)
            self.page.keyboard.down("Shift")
            self.page.mouse.click(*second)
            self.page.keyboard.up("Shift")
            self.page.keyboard.press("g")

    def undo(self):
        self.page.focus("#graph_svg")
        self.page.keyboard.press("Control+z" if self.dice.random() < 0.7 else "Control+Shift+z")

    def step(self):
        kinds = [self.value] * 4 + [self.wire] * 4 + [self.pull_off, self.delete, self.delete, self.add, self.add, self.group, self.undo]
        kind = self.dice.choice(kinds)
        before = text(self.page)
        kind()
        self.wait()
        name = kind.__name__
        if text(self.page) != before:
            self.done[name] = self.done.get(name, 0) + 1
        elif self.at.text("#graph_message"):
            self.refused += 1
        # The stage, all of it in view, so that hands reach it.
        self.page.evaluate("""() => {
            document.getElementById("palette").hidden = true;
            const stage = [...document.querySelectorAll("#graph_tabs button")].find((one) => one.textContent === "@Volume");
            if (stage.ariaSelected !== "true") stage.click();
        }""")
        self.page.focus("#graph_svg")
        self.page.keyboard.press("0")


def main(browser, options):
    seed = int(os.environ.get("OPENFAB_SEED", random.randrange(1 << 30)))
    print(f"        seed {seed}")
    folder = options.out / "random_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "8") as url:
        at = Page(browser, options, size=(1500, 1000), allowed="422")
        page = at.page
        at.open(url, text=True)
        page.click("#graph_button")
        page.wait_for_selector("#graph_svg .node")
        page.click("#graph_look")
        page.uncheck("#graph_save")
        names = iter(range(kEdits))
        page.on("dialog", lambda dialog: dialog.accept(f"part{next(names)}"))
        walk = Walk(at, random.Random(seed))
        start = time.monotonic()
        for edit in range(kEdits):
            walk.step()
            if edit % 20 == 19:
                print(f"        {edit + 1} edits after {time.monotonic() - start:.0f} s", flush=True)
        print(f"        changed {walk.done}, {walk.refused} refused, {walk.compared} compared with the edit by hand")
        check("many edits did something", sum(walk.done.values()) > kEdits / 4 and walk.compared > 10)
        made = text(page)
        page.focus("#graph_svg")
        page.keyboard.press("Control+s")
        at.eventually("the text is saved", lambda: (folder / "ball.fl").read_text() == made)
        checked = subprocess.run([options.bin / "openflc", "check", folder / "ball.fl"], capture_output=True, text=True, check=False)
        check(f"it checks {checked.stderr}", checked.returncode == 0)
        at.settle(500)
        at.eventually("it is printed", lambda: not page.is_visible("#progress"))
        at.shot("random_edits")
        shown = at.text("#stats")
        # As somebody would have typed it: the same tokens, laid out otherwise, in a world that no page has seen.
        hand = options.out / "by_hand"
        shutil.rmtree(hand, ignore_errors=True)
        shutil.copytree(folder, hand)
        (hand / "ball.fl").write_text("\n".join(made.replace("{", "{\n").split("\n")))
        subprocess.run([options.bin / "openfab", "print", hand / "ball.fab.json", "-o", hand / "ball.ofr", "--draft", "8", "--progress", "none"], check=True)
        info = subprocess.run([options.bin / "openfab", "info", hand / "ball.ofr"], capture_output=True, text=True, check=True).stdout
        digest = re.search(r"[0-9a-f]{16}", shown)
        check("it prints what the same by hand prints", digest is not None and digest.group() in info)
        at.close()


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)

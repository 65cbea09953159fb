#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Makes 200 random edits in the graph pane, by mouse and keyboard, in headless Chromium; set up and run as view.py. What is
left is a program that checks, and prints what the same text prints when it was never in a page; values are compared with the
same edit by hand. OPENFAB_SEED=N repeats a walk."""

import os
import pathlib
import random
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import drag, text  # noqa: E402
from view import FABLET, WORLD, Page, Viewer, check, run_with_browser  # noqa: E402

kEdits = 200


def middle(locator):
    box = locator.bounding_box()
    return None if box is None else (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)


def tokens(options, source):
    file = options.out / "tokens.fl"
    file.write_text(source)
    return subprocess.run([options.bin / "openflc", "emit", "--as", "tokens", file], capture_output=True, text=True, check=False).stdout


class Walk:
    def __init__(self, at, dice, options):
        self.at, self.page, self.dice, self.options = at, at.page, dice, options
        self.done, self.refused, self.compared = {}, 0, 0

    def choose(self, selector):
        found = self.page.locator(f"#graph_svg {selector}")
        count = found.count()
        return found.nth(self.dice.randrange(count)) if count else None

    def wait(self):
        """For the answer: the pane is not busy, and what it drew is the text."""
        self.page.wait_for_function("() => !document.body.classList.contains('graph_busy')")

    def value(self):
        """A number in the inspector, and the same by hand."""
        node = self.choose(".node:has(.port circle.free.number)")
        if node is None:
            return
        node.locator(".title").first.click(force=True)
        fields = self.page.locator("#inspector .port_row input.value")
        plain = [i for i in range(fields.count()) if re.fullmatch(r"\d+(\.\d+)?", fields.nth(i).input_value())]
        if not plain:
            return
        field = fields.nth(self.dice.choice(plain))
        old, new = field.input_value(), f"{self.dice.uniform(0.1, 3):.3g}"
        before = text(self.page)
        field.fill(new)
        field.press("Enter")
        self.wait()
        after = text(self.page)
        by_hand = [before[:m.start()] + new + before[m.end():] for m in re.finditer(rf"(?<![\w.]){re.escape(old)}(?![\w.])", before)]
        if after != before:
            self.compared += 1
            self.same = tokens(self.options, after) in [tokens(self.options, one) for one in by_hand]
            if not self.same:
                check(f"{old} became {new} as by hand", False)

    def wire(self):
        start, end = self.choose(".node .out"), self.choose(".node .port .in")
        if start and end and middle(start) and middle(end):
            drag(self.page, middle(start), middle(end))

    def pull_off(self):
        end = self.choose(".node .port .in:not(.free)")
        if end and middle(end):
            box = self.page.locator("#graph_svg").bounding_box()
            drag(self.page, middle(end), (box["x"] + 8, box["y"] + 8))

    def delete(self):
        node = self.choose(".node.call, .node.operator, .node.value")
        if node is not None:
            node.locator(".title").first.click(force=True)
            self.page.focus("#graph_svg")
            self.page.keyboard.press("Delete")

    def add(self):
        self.page.focus("#graph_svg")
        self.page.keyboard.press("Escape")
        self.page.keyboard.press("a")
        self.page.wait_for_selector("#palette:not([hidden])")
        self.page.fill("#palette_search", self.dice.choice(["sin", "abs", "noise", "gyroid", "remap", "min", "+", "*", "smoothstep", "saturate"]))
        self.page.keyboard.press("Enter")

    def undo(self):
        self.page.focus("#graph_svg")
        self.page.keyboard.press("Control+z" if self.dice.random() < 0.7 else "Control+Shift+z")

    def step(self):
        kinds = [self.value] * 4 + [self.wire] * 4 + [self.pull_off, self.delete, self.delete, self.add, self.add, self.undo]
        kind = self.dice.choice(kinds)
        before = text(self.page)
        kind()
        self.wait()
        name = kind.__name__
        if text(self.page) != before:
            self.done[name] = self.done.get(name, 0) + 1
        elif self.at.text("#graph_message"):
            self.refused += 1
        if self.page.is_visible("#palette"):
            self.page.click("#palette_close")
        # All of it in view, so that hands reach it.
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
        at = Page(browser, options, size=(1900, 1300), allowed="422")
        page = at.page
        at.open(url)
        page.click("#graph_button")
        page.wait_for_selector("#graph_svg .node")
        page.click("#graph_look")
        page.uncheck("#graph_save")
        walk = Walk(at, random.Random(seed), options)
        for _ in range(kEdits):
            walk.step()
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
        hand = options.out / "by_hand"
        shutil.rmtree(hand, ignore_errors=True)
        shutil.copytree(folder, hand)
        # As somebody would have typed it: the same tokens, laid out otherwise.
        (hand / "ball.fl").write_text("\n".join(made.replace("{", "{\n").split("\n")))
        subprocess.run([options.bin / "openfab", "print", hand / "ball.fab.json", "-o", hand / "ball.ofr", "--draft", "8", "--progress", "none"], check=True)
        info = subprocess.run([options.bin / "openfab", "info", hand / "ball.ofr"], capture_output=True, text=True, check=True).stdout
        digest = re.search(r"[0-9a-f]{16}", shown)
        check("it prints what the same by hand prints", digest is not None and digest.group() in info)
        at.close()


if __name__ == "__main__":
    run_with_browser(__doc__, main)

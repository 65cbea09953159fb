#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of the page of `openfab view` that documents show, and two animated ones, from today's page. Set up as view.py
is, with pillow besides; then look at each picture in --out.

    out/browser/venv/bin/python tests/browser/pictures.py [--bin build/release/bin] [--page tools/viewer/page] [--update]

With --update they are put into docs/."""

import io
import pathlib
import re
import shutil
import subprocess
import sys

from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import newcomer  # noqa: E402
from graph import drag  # noqa: E402
from harness import Page, Viewer, run_with_browser  # noqa: E402

ROOT = pathlib.Path(__file__).parents[2]
COLORS = 256  # of a palette: pages have few
# The volume is drawn as finely as a machine without a graphics processor can in a quarter of a second; pictures have more time.
PATIENT = "const now = performance.now.bind(performance); performance.now = () => now() / 50;"


def keep(options, name, picture, palette=True):
    """A picture as a palette, which is a third of the size, but takes small patches of like colours as one."""
    file = options.out / name
    picture = picture.convert("RGB")
    if palette:
        picture = picture.quantize(COLORS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    picture.save(file, optimize=True)
    if UPDATE:
        shutil.copy(file, ROOT / "docs" / name)
    print(f"        {name}: {picture.width} x {picture.height}, {file.stat().st_size} bytes")


def keep_animated(options, name, frames, ms):
    """Frames as one picture; the last one stays a while."""
    file = options.out / name
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=[ms] * (len(frames) - 1) + [1800], loop=0, quality=60, method=6)
    if UPDATE:
        shutil.copy(file, ROOT / "docs" / name)
    print(f"        {name}: {frames[0].width} x {frames[0].height}, {len(frames)} frames, {file.stat().st_size} bytes")


def shot(page, clip=None):
    return Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")


def copy_of(options, folder):
    """A folder of the gallery, copied, since the page may change it."""
    to = options.out / "pictures" / folder
    shutil.rmtree(to, ignore_errors=True)
    shutil.copytree(ROOT / "gallery" / folder, to)
    return to


def printed(at):
    at.eventually("the draft is printed", lambda: not at.page.is_visible("#progress"))
    at.settle(3000)


def viewer(browser, options):
    world = copy_of(options, "gyroid_block") / "gyroid.fab.json"
    with Viewer(options, world, "--watch", "--draft", "3") as url:
        at = Page(browser, options, size=(1320, 820))
        page = at.page
        page.add_init_script(PATIENT)
        at.open(url, view=None)
        printed(at)
        page.click("[data-clip='1']")
        page.mouse.move(5, 5)
        box = page.locator("#volume").bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        at.settle(6000)
        keep(options, "viewer.png", shot(page))
        at.close()
        # A slider of the fablet, and the part that follows it.
        at = Page(browser, options, size=(960, 600))
        page = at.page
        page.add_init_script(PATIENT)
        at.open(url, view=None)
        printed(at)
        frames = []
        row = page.locator(".uniform", has_text="thick")
        for value in (2.2, 1.9, 1.6, 1.3, 1.0, 1.4, 1.8, 2.2, 2.6, 3.0, 2.6, 2.2):
            row.locator("input[type=range]").evaluate("(one, value) => { one.value = value; one.dispatchEvent(new Event('input', { bubbles: true })); one.dispatchEvent(new Event('change', { bubbles: true })); }", value)
            at.settle(900)
            printed(at)
            frames.append(shot(page))
        keep_animated(options, "watch.webp", frames, 500)
        at.close()


def graph(browser, options):
    folder = options.out / "pictures" / "cup"
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with Viewer(options, "--new", folder) as url:
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        page.add_init_script(PATIENT)
        at.open(url, view=None)
        printed(at)
        page.click("#graph_button")
        page.wait_for_selector("#graph_svg .node")
        at.settle(2500)
        frames = [shot(page)]

        def take(category, name):
            page.click("#graph_add")
            page.wait_for_selector("#palette_list .tile")
            at.settle(1500)
            frames.append(shot(page))
            page.click(f"#palette_list .tile:has(b:text-is('{category}'))")
            at.settle(1500)
            frames.append(shot(page))
            page.locator(f"#palette_list .entry:has(b:text-is('{name}'))").first.click()
            newcomer.ready(at)
            page.click("#graph_fit")
            printed(at)
            frames.append(shot(page))

        take("Lattices", "gyroid")
        take("Materials", "mix_field")
        label = lambda part: page.locator(f"#graph_svg .node[aria-label*='{part}']").first.get_attribute("aria-label")  # noqa: E731
        gyroid, mix = label("= gyroid"), label("mix_field")
        drag(page, newcomer.by_label(page, gyroid, ".out"), newcomer.by_label(page, mix, "[data-port='2'] .in"))
        newcomer.ready(at)
        printed(at)
        frames.append(shot(page))
        drag(page, newcomer.by_label(page, mix, ".out"), newcomer.by_label(page, "return", "[data-port='0'] .in"))
        newcomer.ready(at)
        page.click("#graph_fit")
        printed(at)
        at.settle(3000)
        frames.append(shot(page))
        keep_animated(options, "graph.webp", [one.resize((960, 600), Image.Resampling.LANCZOS) for one in frames], 1100)
        # Values along z, the text beside.
        page.click("#text_button")
        at.settle(3000)
        page.select_option("#graph_over", "z")
        at.settle(3000)
        page.click("[data-view=z]")
        at.settle(1500)
        box = page.locator("#plane").bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        at.settle(1500)
        page.click("#graph_fit")
        at.settle(6000)
        keep(options, "graph.png", shot(page))
        at.close()


def mechanics(browser, options):
    """The hook of docs/mechanics.md under its load."""
    folder = options.out / "pictures" / "hook"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    text = (ROOT / "docs/mechanics.md").read_text(encoding="utf-8")
    for name in ("mechanics.json", "one.fl", "hook.fab.json"):
        (folder / name).write_text(re.search(rf"`{re.escape(name)}`:\n\n```\w+\n(.*?)```", text, re.S)[1], encoding="utf-8")
    subprocess.run([options.bin / "openfab", "mechanics", "part", "hook.fab.json", "--case", "carry", "--voxel", "0.5mm", "-o", "hook.ofr"], cwd=folder, check=True)
    with Viewer(options, folder / "hook.ofr") as url:
        at = Page(browser, options, size=(1100, 680))
        at.page.add_init_script(PATIENT)
        at.open(url, view="3")
        at.page.click("#details_button")  # the bands of values
        at.settle(8000)
        keep(options, "mechanics-view.png", shot(at.page), palette=False)
        at.close()


def without_text(browser, options):
    newcomer.walk(browser, options)
    keep(options, "without_text.png", Image.open(options.out / "newcomer_part.png"))


def main(browser, options):
    viewer(browser, options)
    graph(browser, options)
    mechanics(browser, options)
    without_text(browser, options)


UPDATE = "--update" in sys.argv
if UPDATE:
    sys.argv.remove("--update")

if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=True)

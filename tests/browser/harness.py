# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What tests of `openfab view` in headless Chromium share: a server, a page whose console must stay empty, checks, and a world
with uniforms."""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys

from playwright.sync_api import sync_playwright

FABLET = """fablet Ball {
    @uniform {
        float skin = 0.6 [[float min = 0.1, float max = 3, string label = "Skin, mm"]];
        int rings = 4 [[int min = 0, int max = 12]];
        float3 tint = {0.2, 0.5, 0.9} [[string widget = "color"]];
        Material core, shell, ink;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0.5, 1, -distance(attr.voxelCenter) / skin);
        float wave = 0.5 + 0.5 * sin(rings * attr.voxelCenter.z);
        mc.Set(core, t * wave);
        mc.Set(ink, t * (1 - wave) * tint.x);
        mc.Set(shell, 1 - t + t * (1 - wave) * (1 - tint.x));
        return mc;
    }
}
"""

WORLD = """{
    "openfab": 1,
    "printer": "j750",
    "fablets": {"ball": {"source": "ball.fl", "fablet": "Ball"}},
    "materials": {
        "white": {"key": "#ffffff", "preview": "#f4f2ecff"},
        "black": {"key": "#000000", "preview": "#161616ff"},
        "cyan": {"key": "#00a0e0", "preview": "#0098dcff"}
    },
    "meshes": {"sphere": {"sphere": 12}},
    "objects": {"ball": {"mesh": "sphere", "fablet": "ball", "uniforms": {"core": "white", "shell": "black", "ink": "cyan"}}},
    "build": [{"object": "ball"}, {"object": "ball", "translate_mm": [14, 0, 0]}]
}
"""

failures = []


def check(what, fine):
    print(("ok      " if fine else "WRONG   ") + what)
    if not fine:
        failures.append(what)


def middle(page, selector, n=0):
    """Returns the middle of the nth match, which may be redrawn at any moment."""
    for _ in range(100):
        box = page.locator(selector).nth(n).bounding_box()
        if box:
            return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.wait_for_timeout(100)
    raise LookupError(selector)


class Viewer:
    def __init__(self, options, *arguments):
        self.process = subprocess.Popen([options.bin / "openfab", "view", *arguments], stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()

    def __enter__(self):
        return self.url

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class Page:
    """A page whose console must stay empty."""

    def __init__(self, browser, options, scheme="light", size=(1440, 860), allowed="409", touch=False):
        self.options = options
        context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme, has_touch=touch, is_mobile=touch)
        context.set_default_timeout(180_000)  # however busy the machine is
        if options.page:
            context.route(re.compile(r"^http://[^/]+/[\w.]*(#.*)?$"), self.from_folder)
        self.page = context.new_page()
        # 409: what was asked for is of a print that another one has just replaced.
        self.page.on("console", lambda m: None if "409" in m.text or allowed in m.text or "GPU stall" in m.text else check(f"console: {m.text} {m.location['url']}", False))
        self.page.on("pageerror", lambda e: check(f"page error: {e}", False))
        self.page.on("request", lambda r: None if r.url.startswith(("http://127.0.0.1:", "blob:")) else check(f"asks {r.url}", False))

    def from_folder(self, route):
        """Serves a file of the page from a folder, so that changes are visible without a build."""
        route.fulfill(path=self.options.page / (route.request.url.split("#")[0].rsplit("/", 1)[1] or "index.html"))

    def close(self):
        """Closes the page before the server ends, since the page polls it."""
        self.page.context.close()

    def open(self, url, ready="#materials li", text=False, view="z"):
        """Opens the page in a view, None: what it opens in, with all that is folded unfolded, and with `text` the text."""
        self.page.goto(url)
        self.page.wait_for_selector(ready, state="attached", timeout=120_000)
        self.page.evaluate("() => document.querySelectorAll('#details details').forEach((one) => { one.open = true; })")
        if view:
            self.page.keyboard.press({"z": "1", "y": "2", "x": "3", "3": "4"}[view])
        if text:
            self.page.click("#text_button")
        self.settle()

    def settle(self, ms=1200):
        self.page.wait_for_timeout(ms)

    def eventually(self, what, fine):
        """Checks that something happens eventually, on any busy machine."""
        for _ in range(200):
            if fine():
                return check(what, True)
            self.settle(300)
        check(what, False)

    def shot(self, name):
        self.page.screenshot(path=self.options.out / f"{name}.png")

    def text(self, selector):
        return self.page.inner_text(selector)

    def pixels(self, selector):
        """Returns the canvas as a data URL, to compare pictures."""
        return self.page.eval_on_selector(selector, "c => c.toDataURL()")

    def colors(self, selector):
        """Returns the number of colours in a sample of a canvas."""
        return self.page.eval_on_selector(selector, """c => {
            const copy = document.createElement("canvas");
            [copy.width, copy.height] = [c.width, c.height];
            const d = copy.getContext("2d");
            d.drawImage(c, 0, 0);
            const data = d.getImageData(0, 0, c.width, c.height).data;
            const seen = new Set();
            for (let i = 0; i < data.length; i += 4 * 37) seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
            return seen.size;
        }""")


def numbers_of(text):
    """Returns the numbers in a text such as `1.234, 5.6 mm`."""
    return [float(word) for word in re.findall(r"-?\d+\.?\d*", text)]


def run_with_browser(about, run, volumes=True):
    """Runs `run(browser, options)` with the command line's options and exits. Without `volumes` the browser draws faster."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default="build/release/bin")
    parser.add_argument("--out", type=pathlib.Path, default="out/browser")
    parser.add_argument("--page", type=pathlib.Path, help="take the page's files from this folder, not from the program")
    options = parser.parse_args()
    options.bin, options.out = options.bin.resolve(), options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox", *(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] if volumes else ["--disable-gpu"])])
        run(browser, options)
        browser.close()
    print(f"{len(failures)} wrong; the screenshots are in {options.out}")
    sys.exit(1 if failures else 0)

# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import pytest
from conftest import BALL

import openfab


def test_describes_uniforms_and_annotations() -> None:
    fablet = openfab.Fablet(text=BALL)
    assert fablet.name == "Ball"
    assert list(fablet.uniforms) == ["skin", "core", "shell"]
    skin = fablet.uniforms["skin"]
    assert (skin.type, skin.kind, skin.default) == ("float", "value", (0.5,))
    assert skin.annotations == {"min": "0", "help": "thickness of the skin, mm"}
    assert fablet.uniforms["core"].kind == "material"
    assert "thickness of the skin" in fablet._repr_html_()


def test_files_and_texts_are_the_same(gallery: Path) -> None:
    file = gallery / "gyroid_block" / "gyroid_block.fl"
    assert openfab.Fablet(file).uniforms == openfab.Fablet(text=file.read_text()).uniforms


def test_an_error_has_the_rendered_text_and_the_place() -> None:
    with pytest.raises(openfab.CompileError) as caught:
        openfab.Fablet(text=BALL.replace("smoothstep", "smothstep"), label="ball.fl")
    error = caught.value
    assert isinstance(error, ValueError)
    assert "ball.fl:6:19: error:" in str(error) and "^~~" in str(error)
    (diagnostic,) = error.diagnostics
    assert (error.line, error.column) == (diagnostic.place.line, diagnostic.place.column) == (6, 19)
    assert diagnostic.place.end_column == 19 + len("smothstep")
    (edit,) = diagnostic.fix
    assert edit.text == "smoothstep"


def test_a_warning_is_a_warning() -> None:
    unused = BALL.replace("MaterialComposition mc;", "MaterialComposition mc; float y = 1 / 0.0;")
    import warnings

    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        openfab.Fablet(text=unused)
    assert all(issubclass(one.category, openfab.CompilerWarning) for one in found)


@pytest.mark.parametrize("name", ["nothing.fl", "."])
def test_what_cannot_be_read_is_an_error(tmp_path: Path, name: str) -> None:
    with pytest.raises(openfab.Error):
        openfab.Fablet(tmp_path / name)


def test_one_of_several_is_named() -> None:
    two = BALL + BALL.replace("Ball", "Other")
    assert openfab.Fablet(text=two, name="Other").name == "Other"
    with pytest.raises(openfab.InputError, match="Ball, Other"):
        openfab.Fablet(text=two)
    with pytest.raises(openfab.InputError, match="no fablet `Third`"):
        openfab.Fablet(text=two, name="Third")


def test_kernels_are_compiled_once() -> None:
    text = BALL.replace("smoothstep(0.5, 1,", "smoothstep(0.4375, 1,")
    openfab.compile(text=text)
    assert openfab.compile(text=text).compile() == 0
    # Another text with the same meaning: its kernels are in the cache.
    assert openfab.Fablet(text=text + "// nothing\n").compile() == 0


def test_a_changed_file_is_compiled_again(tmp_path: Path) -> None:
    file = tmp_path / "ball.fl"
    file.write_text(BALL)
    first = openfab.fablet.programs.find([file])[0]
    assert openfab.fablet.programs.find([file])[0] is first
    file.write_text(BALL.replace("float skin = 0.5", "float skin = 0.25"))
    assert openfab.fablet.programs.find([file])[0] is not first


def test_values_that_have_names() -> None:
    text = BALL.replace("fablet Ball {", 'enum Look { PLAIN, SPOTS = 4 [[ string label = "with spots" ]] };\nfablet Ball {').replace(
        "float skin", 'Look look = SPOTS; bool hollow = false [[ string on = "hollow" ]]; float skin')
    fablet = openfab.Fablet(text=text)
    look = fablet.uniforms["look"]
    assert (look.type, look.default) == ("int", (4,))
    assert look.choices == (("PLAIN", "PLAIN", 0), ("SPOTS", "with spots", 4))
    assert fablet.uniforms["hollow"].choices == (("false", "off", 0), ("true", "hollow", 1))
    world = openfab.World(printer="j750")
    white = openfab.Material("white", "#ffffff")
    ball = world.add(openfab.sphere(3), fablet, {"core": white, "shell": white, "look": "with spots", "hollow": "hollow"})
    ball["look"] = "PLAIN"
    ball["look"] = 4
    for wrong in ("spots", 3):
        with pytest.raises(openfab.InputError, match="one of `PLAIN`, `with spots`"):
            ball["look"] = wrong

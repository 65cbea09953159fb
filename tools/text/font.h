// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lines of text as areas of the plane: Fontconfig finds the font, HarfBuzz shapes the words (kerning,
// ligatures, scripts that join or run from the right) and gives the outlines of their glyphs.

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "mesh/model/outline.h"

namespace openfab::text {

/// The outlines of one glyph in its place on a line, in mm: x from the line's start, y from the
/// baseline.
using Glyph = std::vector<mesh::Outline>;

class Font {
  public:
    /// Opens a font by file, or the font of this system that is nearest to a pattern of Fontconfig,
    /// such as `DejaVu Serif:bold`. A variable font's file may have settings of its axes behind it,
    /// `a.ttf:wght=700`; without any the font's own are used, and told. `capital_mm` is the height of an H.
    static Result<std::unique_ptr<Font>> open(const std::string& name, double capital_mm);
    virtual ~Font() = default;

    /// Shapes one line of UTF-8. Curves become chords that are off by at most 1/1000 of a capital's
    /// height. Fails for a character that the font does not have.
    virtual Result<std::vector<Glyph>> shape(const std::string& line) = 0;
    /// The distance between the baselines of two lines, in mm.
    virtual double line_pitch_mm() const = 0;
    /// The name of the font that was found.
    virtual const std::string& name() const = 0;
};

}  // namespace openfab::text

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh file says of its faces and bodies beside their geometry: how they look, what they are
// for, and what of the file was left out.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace openfab::mesh {

/// What a picture shows beyond 0 … 1. kNone: nothing, what is under the picture is seen.
enum class PictureWrap { kRepeat, kClamp, kMirror, kNone };

/// A picture of a file, as faces use it. Transforms of coordinates are applied to `uv` by the
/// reader.
struct PictureUse {
    std::string source;  ///< where the format's reader finds it again (read_pictures)
    std::string name;    ///< of its file, without folders
    std::array<PictureWrap, 2> wrap{};  ///< along u and v
    /// Coverage: 1, alpha, or alpha from this value up.
    enum class Alpha { kOpaque, kBlend, kMask } alpha = Alpha::kBlend;
    double mask_from = 0.5;
    bool nearest = false;  ///< texels have hard edges
    /// What its numbers are, where the file that uses it says so; kOwn: what the picture says.
    enum class Space { kOwn, kSrgb, kLinear } space = Space::kOwn;
    auto operator<=>(const PictureUse&) const = default;
};

/// How faces look. The colour of a point is `color` times the vertex colour, with the picture:
/// multiplied by it (`tinted`), or over it by the picture's alpha.
struct Look {
    std::string name;                            ///< as in the file; several looks may share one
    std::optional<std::array<double, 3>> color;  ///< linear light, 0 … 1
    double alpha = 1;                            ///< of the colour
    bool vertex_colors = false;                  ///< the attribute `color` counts
    std::optional<PictureUse> picture;           ///< at the attribute `uv`
    bool tinted = false;
    /// It is a mixture of these looks (indices) in these shares of volume, whose sum is 1.
    std::vector<std::pair<int32_t, double>> mixture;
    /// The file names a material to print with, not only a colour to show: faces without picture or
    /// vertex colours are of this material, right through.
    bool is_material = true;
};

/// What a body of a file is for. Negative bodies cut the others of their `assembly`; modifiers,
/// enforcers and the like only say something to a slicer.
enum class BodyRole { kPart, kNegative, kNotPrinted };

/// A body, part or item of a file: one that is placed several times is several.
struct Body {
    std::string name;  ///< as in the file; several bodies may share one
    BodyRole role = BodyRole::kPart;
    int32_t assembly = 0;  ///< bodies of one item of the file
};

/// What was left out, where other readers of the same file may know what to do with it.
enum class LeftOutKind { kOther, kLattices, kLevelSets, kVolumetricData, kDisplacements };

/// Something of a file that was left out: told once, with how often and where first.
struct LeftOut {
    std::string what;    ///< `the morph targets of a mesh`
    std::string place;   ///< of the first; FILE:LINE, or the name of a node, object, material
    std::string remedy;  ///< what the user can do
    int64_t count = 0;
    LeftOutKind kind = LeftOutKind::kOther;
};

/// "the morph targets of a mesh (3 times, first at node `a`): bake them", for messages.
std::string describe(const LeftOut& left_out);

/// Takes a picture's bytes, or why there are none; `index` is that of its source.
using TakePicture = std::function<void(size_t index, Result<std::string> bytes)>;

}  // namespace openfab::mesh

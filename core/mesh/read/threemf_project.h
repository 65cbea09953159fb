// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the slicers of filament printers write beside the model: which triangles or objects are
// parts, holes or modifiers, with which extruder, and the colours of the filaments.
// Sources: PrusaSlicer, Format/3mf.cpp; OrcaSlicer, Format/bbs_3mf.cpp.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mesh/model/look.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

/// A volume of an object: PrusaSlicer's are ranges of its triangles, Bambu Studio's components.
struct ThreemfVolume {
    int64_t first = 0, last = -1;  ///< triangles of the object; none
    int64_t part = -1;             ///< object of the component; -1: it is a range
    std::string name;
    BodyRole role = BodyRole::kPart;
    std::string kind;      ///< what it is if it is not printed
    int32_t extruder = 0;  ///< from 1; 0: the object's
};

/// Triangles of one body.
struct ThreemfPiece {
    const ThreemfVolume* volume = nullptr;  ///< none: what no volume has
    std::vector<int32_t> triangles;         ///< none: all of the object
};

struct ThreemfProjectObject {
    std::string name;
    int32_t extruder = 0;  ///< from 1; 0: not said
    std::vector<ThreemfVolume> volumes;

    bool has_ranges() const;
    /// Returns the volume that is component `object`, or null.
    const ThreemfVolume* component(int64_t object) const;
    /// Splits a mesh at the ranges: a piece for each volume, the last one for what is in none. `*passed`
    /// counts the triangles of the meshes before.
    std::vector<ThreemfPiece> split(const ThreemfObject& object, int64_t* passed) const;
};

struct ThreemfFilament {
    std::string name;
    std::optional<ThreemfColor> color;
    /// Shares of other filaments, from 1, whose sum is 1; empty: it is none.
    std::vector<std::pair<int32_t, double>> mixture;
};

/// Paint that PrusaSlicer 3 stores beside the model.
struct ThreemfAnnotation {
    bool escapes = false;  ///< as of ThreemfObject
    bool used = false;     ///< by an object
    std::vector<std::pair<int32_t, std::string>> paints;
};

struct ThreemfProject {
    std::map<int64_t, ThreemfProjectObject> objects;
    std::vector<ThreemfFilament> filaments;
    std::map<int64_t, ThreemfAnnotation> annotations;  ///< by the object with the mesh

    /// Gives object `id`, called `name`, the paint that stands beside the model; returns what is wrong with it.
    std::string paint(int64_t id, const std::string& name, ThreemfObject* object);
    void tell_of_unused_paint(ThreemfTold* told) const;
};

/// Reads the project of a slicer; an empty one if there is none. Decreases `*memory_bytes`.
Result<ThreemfProject> read_threemf_project(const ZipFile& zip, const std::string& file,
                                            int64_t* memory_bytes, ThreemfTold* told);

}  // namespace openfab::mesh

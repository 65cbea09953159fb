// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files to damage: small and valid, of every kind that a print reads.

#include <functional>
#include <string>
#include <vector>

namespace openfab::testing {

struct Sample {
    enum class Kind { kWorld, kMesh, kPart, kImage, kVolume };
    std::string name;  ///< of the file that is damaged
    Kind kind = Kind::kWorld;
    bool text = true;
    std::string content;
    /// kMesh and kPart: converts the damaged content to the file's bytes, for packages whose
    /// content would otherwise be protected by a checksum; empty: unchanged.
    std::function<std::string(const std::string&)> pack;
    /// kPart: a file that world.fab.json or a mesh reads; what is printed is this one.
    std::string print;
};

/// Files beside all samples: the fablet's source, `world.fab.json`, meshes, a printer.
std::vector<std::pair<std::string, std::string>> sound_files();

std::vector<Sample> samples();

}  // namespace openfab::testing

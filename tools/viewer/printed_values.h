// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a fablet with prints of its nodes (compiler/graph/look.h) has written, by place and node.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/vec.h"

namespace openfab::viewer {

/// What a node is.
struct PrintedValue {
    std::string type;
    size_t numbers = 1;
    std::map<size_t, std::vector<float>> at;  ///< by place
};

/// Lines of printf, read in their order: those of one voxel follow each other, its place first.
class PrintedValues {
  public:
    /// `printed` is the answer to `openfl/look`.
    explicit PrintedValues(const JsonValue& printed);

    void read(std::string_view text);

    /// In mm on the tray; of a surface in those of the part.
    const std::vector<Vec3d>& places() const { return places_; }
    /// By the number of the node.
    const std::map<int32_t, PrintedValue>& values() const { return values_; }

  private:
    void line(std::string_view line);

    bool has_places_;
    std::string point_;
    std::vector<Vec3d> places_;
    std::map<int32_t, PrintedValue> values_;
};

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the page's panel "Part" changes of a world, as text that keeps all else as it is written: the printer, where and how
// large parts are, how a mesh is read, materials, values of uniforms. Other places of a world, and files, are refused.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/json_text.h"
#include "base/result.h"
#include "world/world.h"

namespace openfab::viewer {

/// Returns the text of a world after `edits`, a list of {"path": [names and numbers], "value"}; without a value what is there
/// is left out. All of them, or none.
Result<std::string> part_edited(const std::string& text, const std::string& name,
                                const JsonValue& edits);

/// Writes what the panel shows of a world: its own members as they are written, the printers that there are, and the
/// `sizes_mm` of the items of its build that are objects, as they stand, with their `middles_mm` in part space.
void describe_part(const std::string& text, const world::World* world, JsonText* out);

/// Texts of a world before and after changes by the page. Not thread-safe.
class PartHistory {
  public:
    void record(std::string before, std::string after);
    /// The text to go back to from this one, or forward; nothing where another program has changed it since.
    std::optional<std::string> step(const std::string& now, bool forward);
    bool can_step(const std::string& now, bool forward) const;

  private:
    struct Step {
        std::string before, after;
    };
    std::vector<Step> steps_;
    size_t done_ = 0;  ///< the steps before this are in the text
};

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The materials of the world that an import makes.

#include <array>
#include <map>
#include <string>
#include <vector>

#include "mesh/model/look.h"
#include "tools/openfab/import_text.h"

namespace openfab::tools {

using LinearColor = std::array<double, 3>;

class ImportMaterials {
  public:
    /// `one_white`: what has no colour has that of white in previews, for machines that take these for colours.
    ImportMaterials(const std::vector<mesh::Look>& looks, bool one_white)
        : looks_(looks), one_white_(one_white) {}

    /// Adds the inks and white of coloured skins, once; they have these names.
    void add_inks();
    /// Returns the material of a look, by its name and colour; of one without a colour, a grey.
    std::string of_look(int32_t look);
    /// Returns a material with this name; the same for the same `what`.
    std::string of(const std::string& what, const std::string& name, const LinearColor& color);
    /// Returns a new material, in a grey that none of the last ones has.
    std::string grey(const std::string& name);

    const std::vector<std::string>& lines() const { return lines_; }

  private:
    using Key = std::array<int, 3>;

    std::string add(const std::string& name, const LinearColor& linear, double alpha,
                    bool in_white = false);
    /// Returns a key close to the requested one that no other material has.
    Key free_key(Key key);

    const std::vector<mesh::Look>& looks_;
    const bool one_white_;
    std::vector<std::string> lines_;
    std::map<int32_t, std::string> of_look_;
    std::map<std::string, std::string> of_;
    std::vector<Key> keys_;
    Names names_;
    bool has_inks_ = false;
    int greys_ = 0;
};

}  // namespace openfab::tools

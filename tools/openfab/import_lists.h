// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Uniforms that are lists by group. All objects of a stock fablet share its source, so their lists
// are as long as the longest; they are written once all objects are known.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tools/openfab/import_text.h"

namespace openfab::tools {

class ImportLists {
  public:
    /// The length of lists in the source of a fablet.
    struct Counts {
        size_t groups = 1, maps = 1, parts = 1;
    };
    using Mixture = std::vector<std::vector<std::pair<std::string, double>>>;

    /// Says that a fablet is used.
    void use(const std::string& fablet) { counts_[fablet]; }
    /// A list of JSON values by group of an object of `fablet`.
    void add(size_t object, const std::string& fablet, const std::string& name,
             std::vector<std::string> values);
    /// The textures of an object of the fablet `textured`.
    void add_maps(size_t object, std::vector<std::string> textures);
    /// The mixtures by group of an object of the fablet `mixed`: names and shares of materials.
    void add_mixture(size_t object, Mixture mixture);

    const std::map<std::string, Counts>& fablets() const { return counts_; }
    /// Gives the objects their lists, before their other uniforms.
    void write(std::vector<ObjectText>* objects);

  private:
    struct List {
        size_t object = 0;
        std::string fablet, name;
        std::vector<std::string> values;
    };

    std::map<std::string, Counts> counts_;  ///< by fablet
    std::vector<List> lists_;
    std::vector<std::pair<size_t, std::vector<std::string>>> maps_;
    std::vector<std::pair<size_t, Mixture>> mixtures_;
};

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The text of the worlds that an import makes: names, numbers and lists.

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::tools {

/// Formats a number with at most 5 decimals.
std::string number(double value);

template <typename Things, typename Text>
std::string list_of(const Things& things, const Text& text) {
    std::string out = "[";
    for (const auto& thing : things)
        out += (out.size() > 1 ? ", " : "") + text(thing);
    return out + "]";
}

/// A list, or what it holds where that is one thing.
template <typename Things, typename Text>
std::string one_or_list(const Things& things, const Text& text) {
    return things.size() == 1 ? text(things[0]) : list_of(things, text);
}

/// Makes names unique.
class Names {
  public:
    /// Returns the name itself, else with a number appended.
    std::string unique(const std::string& wanted);

  private:
    std::set<std::string> taken_;
    std::map<std::string, int> next_;
};

/// Returns a file name of characters that are safe for shells and programs.
std::string plain_name(const std::string& name);

/// The uniforms of an object: names and JSON.
using UniformTexts = std::vector<std::pair<std::string, std::string>>;

struct ObjectText {
    std::string name;
    std::string mesh;  ///< JSON of its mesh
    std::string fablet;
    int32_t priority = 0;
    bool support = true, repair = false;
    double most_displacement_mm = 0;  ///< 0: not said
    UniformTexts uniforms;
};

/// The parts of a world, as JSON.
struct WorldText {
    std::string printer;
    std::vector<std::string> fablets;      ///< stock fablets
    std::vector<std::string> own_fablets;  ///< that are written with the world: NAME.fl
    std::vector<std::string> materials, textures;
    std::vector<ObjectText> objects;
    std::string group;  ///< of all objects, where there are several
    double scale = 1;
    std::string translate = "[0, 0]";

    std::string str() const;
};

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tables of measurements say of the light and of the observer that their colours are of.

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::color {

class StatedLight {
  public:
    /// Takes a line of the head of CGATS text, of which the light, the observer and what white is are kept.
    void take(std::string_view keyword, const std::vector<std::string_view>& values);
    void take_light(std::string_view text);
    void take_observer(std::string_view text);

    /// Returns what is said that is not D50 and the observer of 2 degrees, as it is written; else an empty text.
    const std::string& other() const { return other_; }
    /// Whether white is that of the paper.
    bool relative() const { return relative_; }

  private:
    void take_source(std::string_view text);
    void note_other(std::string_view text);

    std::string other_;
    bool relative_ = false;
};

}  // namespace openfab::color

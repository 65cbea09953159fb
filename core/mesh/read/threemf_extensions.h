// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which extensions of 3MF are read, and what is told of the others.

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/xml.h"
#include "mesh/model/look.h"

namespace openfab::mesh {

/// What is left out of a file, each kind of thing once.
class ThreemfTold {
  public:
    void add(const std::string& what, const std::string& place, const std::string& remedy,
             LeftOutKind kind = LeftOutKind::kOther);
    std::vector<LeftOut>& list() { return list_; }

  private:
    std::vector<LeftOut> list_;
};

/// Returns what is wrong with the extensions that a `model` element requires: those that change the
/// surface must be known.
Complaint check_threemf_extensions(const XmlAttributes& model);

/// Returns whether an element is of no interest, with all that is in it; tells of those that
/// matter.
bool is_left_out_of_threemf(std::string_view element, const std::string& place, ThreemfTold* told);

}  // namespace openfab::mesh

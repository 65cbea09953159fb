// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The property groups of a model part of a 3MF file: materials, colours, coordinates of pictures, mixtures
// of materials, and layers of these.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/xml.h"
#include "mesh/read/threemf_element.h"
#include "mesh/read/threemf_model.h"

namespace openfab::mesh {

/// Reads the elements of one model part, in their order.
class ThreemfPropertiesReader : ThreemfElementReader {
  public:
    /// Decreases `*memory_bytes` by what it keeps.
    ThreemfPropertiesReader(ThreemfModel* out, int64_t* memory_bytes)
        : ThreemfElementReader(memory_bytes), model_(*out) {}

    /// Returns whether an element is one of these.
    static bool takes(std::string_view name);
    Complaint start(std::string_view name, const XmlAttributes& a);
    void end(std::string_view name);

  private:
    Complaint begin_group(const XmlAttributes& a, ThreemfGroup::Kind kind);
    Complaint begin_coordinates(const XmlAttributes& a);
    Complaint begin_composites(const XmlAttributes& a);
    Complaint begin_multi(const XmlAttributes& a);
    std::string integers(std::string_view list, std::vector<int64_t>* out);
    Complaint base(const XmlAttributes& a);
    Complaint color(const XmlAttributes& a);
    Complaint texture(const XmlAttributes& a);
    Complaint coordinate(const XmlAttributes& a);
    Complaint composite(const XmlAttributes& a);
    Complaint multi(const XmlAttributes& a);
    bool in(ThreemfGroup::Kind kind) const { return group_ != nullptr && group_->kind == kind; }

    ThreemfModel& model_;
    ThreemfGroup* group_ = nullptr;  ///< the one that is open
};

}  // namespace openfab::mesh

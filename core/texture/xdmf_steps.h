// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The steps of an XDMF file's Temporal collections, and which of them is read. Read before the grid
// itself: a step may name its time behind its arrays, and of all steps but one those are passed over.

#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "base/xml.h"

namespace openfab::texture {

/// Returns an attribute in lower case, under either of its names; empty where there is none.
std::string xdmf_word(const XmlAttributes& attributes, std::string_view name,
                      std::string_view other = {});

/// A step by its index, and the series that it is of: solvers write one for each function.
struct XdmfStep {
    int series = 0, step = 0;
};

/// Finds the series whose first step has the field, where there are several, and its step whose time differs from
/// `time` by at most a millionth of the largest one; without a time its first one. Times are the `Value` of a step's
/// Time, else those that the collection lists, else numbers from 0. Fails where there are several series and `field`
/// names none of them, or where there is a time and no step of it.
Result<XdmfStep> find_xdmf_step(std::string_view text, std::optional<double> time,
                                const std::string& field);

}  // namespace openfab::texture

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The steps of an XDMF file's Temporal collection, and which of them has a time. Read before the grid
// itself: a step may name its time behind its arrays, and of all steps but one those are passed over.

#include <string>
#include <string_view>

#include "base/result.h"
#include "base/xml.h"

namespace openfab::texture {

/// Returns an attribute in lower case, under either of its names; empty where there is none.
std::string xdmf_word(const XmlAttributes& attributes, std::string_view name,
                      std::string_view other = {});

/// Returns the index of the step whose time differs from `time` by at most a millionth of the largest one.
/// Times are the `Value` of a step's Time, else those that the collection lists, else numbers from 0.
/// Fails where the text has no steps, several series of them, or none of that time.
Result<int> find_xdmf_step(std::string_view text, double time);

}  // namespace openfab::texture

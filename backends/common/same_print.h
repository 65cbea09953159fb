// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a print may take up another one's output.

#include <string>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::backends {

/// Empty where both print the same voxels; else what differs first, as "the dither is `blue_noise`
/// there and `decorrelated` here", for messages. What is not known to be the same differs.
std::string first_difference(const PrintInfo& there, const PrintInfo& here);

/// "the dither is `a` there and `b` here"; of hashes, which tell nobody anything, "the meshes are
/// not the same".
std::string differs(const std::string& what, const std::string& there, const std::string& here);

/// The error for an output that cannot be taken up, with a way out; `why` as above.
Error cannot_take_up(const std::string& output, const std::string& why);

}  // namespace openfab::backends

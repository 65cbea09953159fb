// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks whether a print may resume another one's output.

#include <string>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::backends {

/// Compares two prints; returns an empty text if both print the same voxels, else the first
/// difference, for messages, such as "the dither is `blue_noise` there and `decorrelated` here".
/// Unknown settings count as different.
std::string first_difference(const pipeline::PrintInfo& there, const pipeline::PrintInfo& here);

/// Formats "the dither is `a` there and `b` here"; for hashes, which mean nothing to people, "the
/// meshes are not the same".
std::string differs(const std::string& what, const std::string& there, const std::string& here);

/// Makes the error for an output that cannot be resumed; `why` as above.
Error resume_refused(const std::string& output, const std::string& why);

}  // namespace openfab::backends

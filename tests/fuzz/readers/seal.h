// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checksums of damaged files. Who writes a file to do harm makes them right.

#include <string>

namespace openfab::testing {

/// Of a cached texture.
void seal_pyramid(std::string* bytes);
/// Of a print's header, the heads of its slices, and its index.
void seal_print(std::string* bytes);
/// Of a store of Zarr as the readers' corpus has it: the head of the list, and the index of the shard.
void seal_store(std::string* bytes);
/// Of what messages hold of a print.
void seal_messages(std::string* bytes);

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Digests of the files in a folder of slices: in its manifest, and in `SHA256SUMS`, as `sha256sum --check`
// takes it. Beside each the manifest has a seal, the digest of the print's identity, the file's name and
// the file's digest: a slice of another print, or of another place, has none in this folder, even if its
// digest came with it. While a print runs the seals are in `SHA256SUMS.part`, a line behind each file, under
// a first line that says which print they are of: names that come back after a power loss are told from its
// own.

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/json.h"
#include "base/result.h"
#include "base/sha256.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

constexpr const char* kDigestFile = "SHA256SUMS";
constexpr const char* kDigestsSoFar = "SHA256SUMS.part";

/// Largest manifest and list of digests that are read.
constexpr int64_t kMostManifestBytes = int64_t{256} << 20;
/// Each file of a slice has a digest and a seal.
constexpr size_t kMostManifestValues = 10'000'000;

/// By the file's name.
using Digests = std::map<std::string, Sha256Digest, std::less<>>;

/// Parses a manifest; none where it is damaged.
std::optional<JsonValue> parse_manifest(std::string_view text);

/// Returns the identity of the print whose manifest is `manifest`: the digest of all that its first manifest
/// has, too, which is what the print is made of. The same while it runs and at its end; none where the
/// manifest is damaged.
std::optional<Sha256Digest> print_identity(const std::string& manifest);

/// Returns the seal of a file of a print.
Sha256Digest seal_of(const Sha256Digest& identity, std::string_view name,
                     const Sha256Digest& digest);

/// Formats the line of a file, as `sha256sum` does.
std::string digest_line(std::string_view name, const Sha256Digest& digest);

/// Returns the first line of the list of a running print, whose first manifest is `manifest`.
std::string digests_head(std::string_view manifest);

/// Parses the list of a running print up to its first damaged line; empty where `head` is not its first.
Digests parse_digests(std::string_view text, std::string_view head);

/// Returns those in a manifest; empty where it has none.
Digests manifest_digests(const std::string& manifest);
Digests manifest_seals(const std::string& manifest);

}  // namespace openfab::raster

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/slice_digests.h"

#include <fmt/format.h>

#include "base/json_text.h"

namespace openfab::raster {

namespace {

constexpr size_t kDigits = 64;
constexpr std::string_view kBetween = "  ";

}  // namespace

std::string digest_line(std::string_view name, const Sha256Digest& digest) {
    return fmt::format("{}{}{}\n", hex_text(digest), kBetween, name);
}

std::string digests_head(std::string_view manifest) {
    return fmt::format("# of the print {}\n", hex_text(sha256(manifest)));
}

Digests parse_digests(std::string_view text, std::string_view head) {
    Digests digests;
    if (!text.starts_with(head)) return digests;
    text.remove_prefix(head.size());
    for (size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(end + 1);
        Sha256Digest digest{};
        const bool fine = line.size() > kDigits + kBetween.size() &&
                          line.substr(kDigits, kBetween.size()) == kBetween &&
                          parse_hex(line.substr(0, kDigits), &digest);
        if (!fine) break;
        digests[std::string(line.substr(kDigits + kBetween.size()))] = digest;
    }
    return digests;
}

Sha256Digest seal_of(const Sha256Digest& identity, std::string_view name,
                     const Sha256Digest& digest) {
    return sha256(fmt::format("slice of {}\n{}", hex_text(identity), digest_line(name, digest)));
}

namespace {

Digests digests_under(const char* key, const std::string& manifest) {
    Digests digests;
    const std::optional<JsonValue> root = parse_manifest(manifest);
    const JsonValue* const files = root ? member_of(*root, key) : nullptr;
    if (files == nullptr) return digests;
    for (const JsonMember& file : files->members) {
        Sha256Digest digest{};
        if (parse_hex(file.value.text, &digest)) digests[file.key] = digest;
    }
    return digests;
}

}  // namespace

Digests manifest_digests(const std::string& manifest) {
    return digests_under("sha256", manifest);
}

Digests manifest_seals(const std::string& manifest) {
    return digests_under("seals", manifest);
}

}  // namespace openfab::raster

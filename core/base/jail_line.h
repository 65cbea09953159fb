// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a reader in a jail hands to its parent. One function `pass` for each type is both ends: it sends on one of them,
// and fills on the other. The parent trusts nothing: counts are bounded by memory, and what numbers mean is checked by
// who takes them.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/large_pages.h"
#include "base/result.h"
#include "base/source_location.h"

namespace openfab {

class JailLine {
  public:
    /// One end of a pipe. The receiving one takes `most_bytes` altogether.
    JailLine(int descriptor, bool sends, int64_t most_bytes = 0)
        : descriptor_(descriptor), sends_(sends), left_(most_bytes) {}

    bool sends() const { return sends_; }
    /// Whether all came so far, and made sense.
    bool fine() const { return fine_; }
    void fail() { fine_ = false; }

    /// Sends or receives. After a failure all that is received is 0.
    void bytes(void* data, size_t count);

    /// Takes memory of the receiver for `count` things; false, and failed, if there is not as much.
    bool take(uint64_t count, size_t bytes_each);

  private:
    int descriptor_;
    bool sends_, fine_ = true;
    int64_t left_;
};

template <typename T>
inline constexpr bool kHasTruth = std::is_same_v<T, bool>;
template <typename T>
inline constexpr bool kHasTruth<std::optional<T>> = true;

/// What may come as bytes: of others not each byte is a value.
template <typename T>
concept Plain = std::is_trivially_copyable_v<T> && !kHasTruth<T>;

template <Plain T>
void pass(JailLine* line, T* value) {
    line->bytes(value, sizeof *value);
}

inline void pass(JailLine* line, bool* value) {
    uint8_t byte = line->sends() && *value ? 1 : 0;
    pass(line, &byte);
    *value = byte != 0;
}

/// Passes how many there are, and returns it; 0 if they cannot be.
inline size_t pass_count(JailLine* line, size_t count, size_t bytes_each) {
    uint64_t n = count;
    pass(line, &n);
    if (line->sends()) return count;
    return line->fine() && line->take(n, bytes_each) ? n : 0;
}

inline void pass(JailLine* line, std::string* text) {
    const size_t count = pass_count(line, text->size(), 1);
    if (!line->sends()) text->resize(count);
    line->bytes(text->data(), count);
}

inline void pass(JailLine* line, std::filesystem::path* path) {
    std::string text = line->sends() ? path->string() : std::string();
    pass(line, &text);
    if (!line->sends()) *path = text;
}

template <typename A, typename B>
void pass(JailLine* line, std::pair<A, B>* both) requires(!Plain<std::pair<A, B>>) {
    pass(line, &both->first);
    pass(line, &both->second);
}

template <typename T>
void pass(JailLine* line, std::optional<T>* value) {
    bool has = value->has_value();
    pass(line, &has);
    if (!line->sends()) {
        if (has)
            value->emplace();
        else
            value->reset();
    }
    if (has) pass(line, &**value);
}

/// A vector that was sent is freed: the other end has it.
template <typename T>
void pass(JailLine* line, std::vector<T>* values) {
    const size_t count = pass_count(line, values->size(), sizeof(T));
    if constexpr (Plain<T>) {
        // In parts that stay in the cache between being made and being filled.
        constexpr size_t kPart = std::max<size_t>(1, (1 << 18) / sizeof(T));
        if (!line->sends()) {
            values->clear();
            reserve_large(values, count);
        }
        for (size_t at = 0; at < count && line->fine(); at += kPart) {
            const size_t part = std::min(kPart, count - at);
            if (!line->sends()) values->resize(at + part);
            line->bytes(values->data() + at, part * sizeof(T));
        }
    } else {
        if (!line->sends()) values->clear();
        for (size_t i = 0; i < count && line->fine(); ++i) {
            if (!line->sends()) values->emplace_back();
            pass(line, &(*values)[i]);
        }
    }
    if (line->sends()) std::vector<T>().swap(*values);
}

inline void pass(JailLine* line, SourceLocation* location) {
    pass(line, &location->file);
    pass(line, &location->line);
    pass(line, &location->column);
}

/// A code that there is not fails.
void pass(JailLine* line, Error* error);

}  // namespace openfab

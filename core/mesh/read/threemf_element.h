// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What readers of a 3MF model's elements share.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/xml.h"

namespace openfab::mesh {

/// Reads values of attributes, and accounts for the memory of lists.
class ThreemfElementReader {
  protected:
    static constexpr int64_t kMaxId = INT32_MAX;

    /// `*memory_bytes` is decreased by what is read.
    explicit ThreemfElementReader(int64_t* memory_bytes) : memory_bytes_(*memory_bytes) {}

    /// Appends to a list and accounts for its memory: lists double, and are copied then.
    template <typename T>
    T& add(std::vector<T>* list, T value, size_t more = 0) {
        memory_bytes_ -= static_cast<int64_t>(3 * sizeof(T) + more);
        list->push_back(std::move(value));
        return list->back();
    }

    /// Accounts for the memory of a resource's map entry and name.
    template <typename T>
    void take(const std::string& name) {
        constexpr size_t kNode = 64;
        memory_bytes_ -= static_cast<int64_t>(sizeof(T) + kNode + name.size());
    }

    /// Complains of a name that nobody would write.
    static Complaint too_long(const std::string& name);

    // Values of attributes; of one that is wrong wrong_ says why.
    double number(const XmlAttributes& a, const char* key);
    int64_t integer(const XmlAttributes& a, const char* key, int64_t otherwise);
    int64_t needed_integer(const XmlAttributes& a, const char* key);
    int64_t index(std::string_view name, const char* text);
    static std::string attribute(const XmlAttributes& a, const char* key);

    int64_t& memory_bytes_;
    std::string wrong_;  ///< of this element's attributes
};

}  // namespace openfab::mesh

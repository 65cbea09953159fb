// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_element.h"

#include <fmt/format.h>

#include "base/scan_number.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {

Complaint ThreemfElementReader::too_long(const std::string& name) {
    constexpr size_t kLongest = 1000;
    if (name.size() <= kLongest) return {};
    return {fmt::format(messages::kLongName, name.size()),
            fmt::format(messages::kAtMost, kLongest)};
}

double ThreemfElementReader::number(const XmlAttributes& a, const char* key) {
    const char* text = a.find(key);
    double value = 0;
    if (text == nullptr) {
        wrong_ = fmt::format(messages::kAttributeMissing, key);
    } else if (const std::string wrong = scan_number(trim_threemf(text), &value); !wrong.empty()) {
        wrong_ = wrong;
    }
    return value;
}

int64_t ThreemfElementReader::integer(const XmlAttributes& a, const char* key, int64_t otherwise) {
    const char* text = a.find(key);
    if (text == nullptr) return otherwise;
    int64_t value = otherwise;
    if (const std::string wrong = scan_integer(trim_threemf(text), 0, kMaxId, &value);
        !wrong.empty())
        wrong_ = fmt::format("`{}`: {}", key, wrong);
    return value;
}

int64_t ThreemfElementReader::needed_integer(const XmlAttributes& a, const char* key) {
    const int64_t value = integer(a, key, -1);
    if (value < 0 && wrong_.empty()) wrong_ = fmt::format(messages::kAttributeMissing, key);
    return value;
}

int64_t ThreemfElementReader::index(std::string_view name, const char* text) {
    int64_t value = -1;
    if (const std::string wrong = scan_integer(trim_threemf(text), 0, kMaxId, &value);
        !wrong.empty())
        wrong_ = fmt::format("`{}`: {}", name, wrong);
    return value;
}

std::string ThreemfElementReader::attribute(const XmlAttributes& a, const char* key) {
    const char* value = a.find(key);
    return value != nullptr ? value : "";
}

}  // namespace openfab::mesh

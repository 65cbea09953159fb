// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/meta_header.h"

#include <algorithm>
#include <string_view>

#include "base/text.h"
#include "texture/data_files.h"
#include "texture/messages.h"

namespace openfab::texture {

namespace {

constexpr int64_t kLongest = 1 << 20;

std::string trimmed(const std::string& text) {
    constexpr const char* kBlanks = " \t\r";
    const size_t first = text.find_first_not_of(kBlanks);
    if (first == std::string::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

std::string MetaHeader::field(const char* name, const char* other, const char* another) const {
    for (const char* key : {name, other, another}) {
        if (key == nullptr) continue;
        if (const auto found = fields.find(key); found != fields.end()) return found->second;
    }
    return {};
}

std::string MetaHeader::data_file() const {
    const std::string name = field("ElementDataFile");
    return name == "LOCAL" || name == "Local" || name == "local" ? "" : name;
}

bool is_meta_image(const std::filesystem::path& file) {
    const std::string kind = lower_ascii(file.extension().string());
    return kind == ".mha" || kind == ".mhd";
}

Result<MetaHeader> read_meta_header(const InputFile& file) {
    std::string bytes(static_cast<size_t>(std::min(file.bytes(), kLongest)), '\0');
    const Result<size_t> got = file.read(0, bytes.data(), bytes.size());
    if (!got) return got.error();
    bytes.resize(*got);
    MetaHeader header;
    for (size_t begin = 0; begin < bytes.size();) {
        const size_t end = std::min(bytes.find('\n', begin), bytes.size());
        const std::string line = bytes.substr(begin, end - begin);
        begin = end + 1;
        const size_t sign = line.find('=');
        if (trimmed(line).empty()) continue;
        if (sign == std::string::npos) break;
        const std::string key = trimmed(line.substr(0, sign));
        header.fields[key] = trimmed(line.substr(sign + 1));
        if (key != "ElementDataFile") continue;
        header.begin = static_cast<int64_t>(std::min(begin, bytes.size()));
        if (is_file_list(header.data_file()))
            header.listed = lines_of(std::string_view(bytes).substr(std::min(begin, bytes.size())));
        return header;
    }
    return user_error(messages::kNotMetaImage);
}

}  // namespace openfab::texture

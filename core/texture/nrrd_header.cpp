// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/nrrd_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/text.h"
#include "texture/data_files.h"
#include "texture/messages.h"

namespace openfab::texture {

namespace {

constexpr int64_t kLongest = 1 << 20;
constexpr std::string_view kBlanks = " \t";

}  // namespace

std::string NrrdHeader::field(const std::string& name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string() : found->second;
}

std::string NrrdHeader::data_file() const {
    const std::string name = field("data file");
    return name.empty() ? field("datafile") : name;
}

Result<NrrdHeader> read_nrrd_header(const InputFile& file) {
    std::string bytes(static_cast<size_t>(std::min(file.bytes(), kLongest)), '\0');
    const Result<size_t> got = file.read(0, bytes.data(), bytes.size());
    if (!got) return got.error();
    bytes.resize(*got);
    if (bytes.compare(0, 4, "NRRD") != 0) return user_error(messages::kNotNrrd);
    NrrdHeader header;
    size_t at = bytes.find('\n');
    while (at != std::string::npos && at + 1 < bytes.size()) {
        const size_t begin = at + 1;
        at = bytes.find('\n', begin);
        std::string line =
            bytes.substr(begin, (at == std::string::npos ? bytes.size() : at) - begin);
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.empty()) break;
        const size_t colon = line.find(": ");
        // `name:=value` is a note of its writer, not a field.
        if (line[0] == '#' || colon == std::string::npos || line.find(":=") < colon) continue;
        // As teem reads them: names in any case, and any blanks around a value.
        const size_t first = line.find_first_not_of(kBlanks, colon + 2);
        const size_t last = line.find_last_not_of(kBlanks);
        const std::string name = lower_ascii(line.substr(0, colon));
        header.fields[name] =
            first == std::string::npos ? std::string() : line.substr(first, last + 1 - first);
        if (!is_file_list(header.data_file()) || at == std::string::npos) continue;
        header.listed = lines_of(std::string_view(bytes).substr(at + 1));
        at = std::string::npos;
    }
    header.begin = static_cast<int64_t>(at == std::string::npos ? bytes.size() : at + 1);
    return header;
}

Result<InputFile> open_data_file(const std::filesystem::path& file, const std::string& name,
                                 const ReadLimits& limits) {
    std::vector<std::filesystem::path> roots = limits.roots;
    if (roots.empty()) roots.push_back(reading_root(file.parent_path()));
    Result<InputFile> opened = InputFile::open(file.parent_path() / name, roots);
    if (opened) return opened;
    return with_context(opened.error(), fmt::format(messages::kDataFileUnreadable, name));
}

}  // namespace openfab::texture

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

constexpr size_t kLongestLine = 4096;
constexpr size_t kMaxProperties = 1000;
constexpr int64_t kMaxElements = 200'000'000;

std::optional<PlyType> type_named(std::string_view name) {
    static constexpr std::pair<std::string_view, PlyType> kTypes[] = {
        {"char", PlyType::kInt8},      {"int8", PlyType::kInt8},
        {"uchar", PlyType::kUint8},    {"uint8", PlyType::kUint8},
        {"short", PlyType::kInt16},    {"int16", PlyType::kInt16},
        {"ushort", PlyType::kUint16},  {"uint16", PlyType::kUint16},
        {"int", PlyType::kInt32},      {"int32", PlyType::kInt32},
        {"uint", PlyType::kUint32},    {"uint32", PlyType::kUint32},
        {"float", PlyType::kFloat32},  {"float32", PlyType::kFloat32},
        {"double", PlyType::kFloat64}, {"float64", PlyType::kFloat64}};
    for (const auto& [known, type] : kTypes) {
        if (known == name) return type;
    }
    return {};
}

class HeaderReader {
  public:
    HeaderReader(std::string_view bytes, const std::string& file)
        : bytes_(bytes),
          file_(file),
          at_(bytes.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0) {}

    Result<PlyHeader> read() {
        if (!next_line() || words_.size() != 1 || words_[0] != "ply")
            return error(messages::kNotPly);
        bool has_format = false;
        while (next_line()) {
            if (words_.empty() || words_[0] == "obj_info") continue;
            if (words_[0] == "comment") {
                comment();
                continue;
            }
            if (words_[0] == "end_header") {
                if (!has_format) return error(messages::kHeaderWithoutFormat);
                out_.body = at_;
                out_.body_line = line_ + 1;
                return std::move(out_);
            }
            Result<void> done = Ok{};
            if (words_[0] == "format") {
                done = format();
                has_format = true;
            } else if (words_[0] == "element") {
                done = element();
            } else if (words_[0] == "property") {
                done = property();
            } else {
                done = error(fmt::format(messages::kUnknownHeaderStatement, shown(words_[0])));
            }
            if (!done) return done.error();
        }
        return error(messages::kHeaderWithoutEnd, messages::kHeaderWithoutEndHelp);
    }

  private:
    bool next_line() {
        ++line_;
        words_.clear();
        if (at_ >= bytes_.size()) return false;
        // Some writers end lines with a carriage return alone.
        const size_t end = bytes_.find_first_of("\r\n", at_);
        if (end == std::string_view::npos || end - at_ > kLongestLine) return false;
        std::string_view line = bytes_.substr(at_, end - at_);
        at_ = end + (bytes_.substr(end, 2) == "\r\n" ? 2 : 1);
        while (!line.empty()) {
            const size_t start = line.find_first_not_of(" \t");
            if (start == std::string_view::npos) break;
            line.remove_prefix(start);
            const size_t length = std::min(line.find_first_of(" \t"), line.size());
            words_.push_back(line.substr(0, length));
            line.remove_prefix(length);
        }
        return true;
    }

    /// `comment TextureFile NAME`: the rest of the line, since names have blanks.
    void comment() {
        constexpr size_t kMostPictures = 1000;
        if (words_.size() < 3 || lower_ascii(std::string(words_[1])) != "texturefile") return;
        const char* start = words_[2].data();
        std::string_view name(
            start, static_cast<size_t>(words_.back().data() - start) + words_.back().size());
        if (name.size() > 2 && name.front() == '"' && name.back() == '"')
            name = name.substr(1, name.size() - 2);
        if (out_.pictures.size() < kMostPictures) out_.pictures.emplace_back(name);
    }

    static std::string_view shown(std::string_view word) { return word.substr(0, 40); }

    Error error(const std::string& what, const std::string& help = {}) const {
        return error_at({file_, line_, 1}, what, help);
    }

    Result<void> format() {
        if (words_.size() != 3 || words_[2] != "1.0") return error(messages::kFormatStatement);
        out_.ascii = words_[1] == "ascii";
        out_.big_endian = words_[1] == "binary_big_endian";
        if (!out_.ascii && !out_.big_endian && words_[1] != "binary_little_endian")
            return error(fmt::format(messages::kUnknownFormat, shown(words_[1])));
        return Ok{};
    }

    Result<void> element() {
        if (words_.size() != 3) return error(messages::kElementStatement);
        PlyElement element;
        element.name = words_[1];
        const std::string wrong = scan_integer(words_[2], 0, kMaxElements, &element.count);
        if (!wrong.empty()) return error(wrong);
        if (out_.elements.size() >= kMaxProperties) return error(messages::kTooManyElements);
        for (const PlyElement& other : out_.elements) {
            if (other.name == element.name)
                return error(fmt::format(messages::kSecondElement, shown(element.name)));
        }
        out_.elements.push_back(std::move(element));
        return Ok{};
    }

    Result<void> property() {
        if (out_.elements.empty()) return error(messages::kPropertyBeforeElement);
        PlyElement& element = out_.elements.back();
        PlyProperty property;
        property.is_list = words_.size() == 5 && words_[1] == "list";
        if (!property.is_list && words_.size() != 3) return error(messages::kPropertyStatement);
        for (size_t i = property.is_list ? 2 : 1; i + 1 < words_.size(); ++i) {
            const std::optional<PlyType> type = type_named(words_[i]);
            if (!type) return error(fmt::format(messages::kUnknownType, shown(words_[i])));
            if (property.is_list && i == 2) property.count_type = *type;
            property.type = *type;
        }
        property.name = words_.back();
        if (property.is_list && !is_ply_integer(property.count_type))
            return error(messages::kListLengthType);
        if (element.properties.size() >= kMaxProperties) return error(messages::kTooManyProperties);
        for (const PlyProperty& other : element.properties) {
            if (other.name == property.name)
                return error(fmt::format(messages::kSecondProperty, shown(property.name)));
        }
        element.properties.push_back(std::move(property));
        return Ok{};
    }

    std::string_view bytes_;
    const std::string& file_;
    size_t at_;
    int32_t line_ = 0;
    std::vector<std::string_view> words_;
    PlyHeader out_;
};

}  // namespace

size_t ply_type_bytes(PlyType type) {
    static constexpr size_t kBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return kBytes[static_cast<size_t>(type)];
}

Result<PlyHeader> parse_ply_header(std::string_view bytes, const std::string& file) {
    return HeaderReader(bytes, file).read();
}

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// NRRD, https://teem.sourceforge.net/nrrd/format.html, as far as scanners and simulations write it.

#include <fmt/format.h>
#include <libdeflate.h>

#include <cmath>
#include <map>
#include <sstream>

#include "tools/texture/volume_reader.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

class NrrdReader final : public VolumeReader {
  public:
    std::string bytes;
    size_t begin = 0;
    NumberFormat format;
    bool text = false;

    Result<void> read(float* out) override {
        const int64_t count =
            static_cast<int64_t>(size.x) * size.y * size.z * static_cast<int64_t>(channels);
        if (text) {
            std::istringstream in(bytes.substr(begin));
            for (int64_t i = 0; i < count; ++i) {
                double value = 0;
                in >> value;
                const double largest = format.kind != NumberFormat::Kind::kUnsigned ? 1
                                       : format.bytes == 1                          ? 255
                                       : format.bytes == 2                          ? 65535
                                                                                    : 1;
                out[i] = static_cast<float>(value / largest);
            }
            if (!in) return user_error("it is cut short");
            return Ok{};
        }
        for (int64_t i = 0; i < count; ++i)
            out[i] =
                read_number(format, bytes.data() + begin + static_cast<size_t>(i * format.bytes));
        return Ok{};
    }
};

bool number_format(const std::string& type, NumberFormat* out) {
    using Kind = NumberFormat::Kind;
    static const std::map<std::string, std::pair<Kind, int>> kTypes = {
        {"signed char", {Kind::kSigned, 1}},
        {"int8", {Kind::kSigned, 1}},
        {"int8_t", {Kind::kSigned, 1}},
        {"uchar", {Kind::kUnsigned, 1}},
        {"unsigned char", {Kind::kUnsigned, 1}},
        {"uint8", {Kind::kUnsigned, 1}},
        {"uint8_t", {Kind::kUnsigned, 1}},
        {"short", {Kind::kSigned, 2}},
        {"int16", {Kind::kSigned, 2}},
        {"int16_t", {Kind::kSigned, 2}},
        {"ushort", {Kind::kUnsigned, 2}},
        {"unsigned short", {Kind::kUnsigned, 2}},
        {"uint16", {Kind::kUnsigned, 2}},
        {"uint16_t", {Kind::kUnsigned, 2}},
        {"int", {Kind::kSigned, 4}},
        {"int32", {Kind::kSigned, 4}},
        {"int32_t", {Kind::kSigned, 4}},
        {"uint", {Kind::kUnsigned, 4}},
        {"unsigned int", {Kind::kUnsigned, 4}},
        {"uint32", {Kind::kUnsigned, 4}},
        {"uint32_t", {Kind::kUnsigned, 4}},
        {"float", {Kind::kFloat, 4}},
        {"double", {Kind::kFloat, 8}},
    };
    const auto found = kTypes.find(type);
    if (found == kTypes.end()) return false;
    out->kind = found->second.first;
    out->bytes = found->second.second;
    return true;
}

/// `(1,0,0)`; false for `none` and anything else.
bool vector_of(const std::string& word, std::array<double, 3>* out) {
    char open = 0, first = 0, second = 0, close = 0;
    std::istringstream in(word);
    in >> open >> (*out)[0] >> first >> (*out)[1] >> second >> (*out)[2] >> close;
    return static_cast<bool>(in) && open == '(' && close == ')';
}

/// Words; those in brackets stay whole.
std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> out;
    std::string word;
    bool in_brackets = false;
    for (const char c : text + " ") {
        in_brackets = c == '(' || (in_brackets && c != ')');
        if (c != ' ' && c != '\t') {
            word += c;
        } else if (!in_brackets && !word.empty()) {
            out.push_back(std::move(word));
            word.clear();
        }
    }
    return out;
}

using Fields = std::map<std::string, std::string>;

/// Lines up to the empty one; `end` is the first byte behind it.
Fields fields_of(const std::string& bytes, size_t* end) {
    Fields fields;
    size_t at = bytes.find('\n');
    while (at != std::string::npos && at + 1 < bytes.size()) {
        const size_t begin = at + 1;
        at = bytes.find('\n', begin);
        std::string line =
            bytes.substr(begin, (at == std::string::npos ? bytes.size() : at) - begin);
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.empty()) break;
        const size_t colon = line.find(": ");
        if (line[0] != '#' && colon != std::string::npos)
            fields[line.substr(0, colon)] = line.substr(colon + 2);
    }
    *end = at == std::string::npos ? bytes.size() : at + 1;
    return fields;
}

Result<std::string> unpack(const std::string& packed, size_t begin, size_t bytes) {
    std::string out(bytes, 0);
    libdeflate_decompressor* d = libdeflate_alloc_decompressor();
    size_t used = 0, got = 0;
    const libdeflate_result result = libdeflate_gzip_decompress_ex(
        d, packed.data() + begin, packed.size() - begin, out.data(), out.size(), &used, &got);
    libdeflate_free_decompressor(d);
    if (result != LIBDEFLATE_SUCCESS || got != bytes)
        return user_error("its compressed data is damaged or of another size than it says");
    return out;
}

/// Spacing and origin; an error for axes that are turned.
Result<void> place(const Fields& fields, size_t first, NrrdReader* reader) {
    const auto field = [&](const char* name) {
        const auto found = fields.find(name);
        return found == fields.end() ? std::vector<std::string>{} : words_of(found->second);
    };
    std::array<double, 3> spacing{1, 1, 1}, middle{};
    bool known = false;
    if (const auto directions = field("space directions"); directions.size() == first + 3) {
        for (size_t a = 0; a < 3; ++a) {
            std::array<double, 3> v{};
            if (!vector_of(directions[first + a], &v))
                return user_error("its `space directions` are not understood");
            for (size_t k = 0; k < 3; ++k) {
                if (k != a && std::fabs(v[k]) > 1e-6 * std::fabs(v[a]))
                    return user_error("its axes are turned; write it along x, y and z");
            }
            if (!(v[a] > 0))
                return user_error("an axis of it runs downwards; write it along x, y and z");
            spacing[a] = v[a];
        }
        known = true;
    } else if (const auto sizes = field("spacings"); sizes.size() == first + 3) {
        for (size_t a = 0; a < 3; ++a) {
            spacing[a] = std::strtod(sizes[first + a].c_str(), nullptr);
            if (!(spacing[a] > 0)) return user_error("its `spacings` are not above 0");
        }
        known = true;
    }
    if (known) reader->spacing = spacing;
    if (const auto origin = field("space origin"); origin.size() == 1) {
        if (!vector_of(origin[0], &middle))
            return user_error("its `space origin` is not understood");
        reader->origin.emplace();
        for (size_t a = 0; a < 3; ++a)
            (*reader->origin)[a] = middle[a] - spacing[a] / 2;
    }
    return Ok{};
}

}  // namespace

MadeReader open_nrrd(const fs::path& file) {
    Result<std::string> bytes = read_whole(file);
    if (!bytes) return bytes.error();
    if (bytes->compare(0, 4, "NRRD") != 0) return user_error("it is no NRRD file");
    auto reader = std::make_unique<NrrdReader>();
    Fields fields = fields_of(*bytes, &reader->begin);
    if (!number_format(fields["type"], &reader->format))
        return user_error(
            fmt::format("its numbers are of type `{}`, which is not known", fields["type"]));
    reader->format.swapped = fields["endian"] == "big";
    const std::vector<std::string> sizes = words_of(fields["sizes"]);
    if (sizes.size() != 3 && sizes.size() != 4)
        return user_error(fmt::format(
            "it has {} dimensions; 3, or 4 with the channels first, are right", sizes.size()));
    const size_t first = sizes.size() - 3;
    std::array<int64_t, 4> n{1, 1, 1, 1};
    size_t numbers = 1;
    for (size_t k = 0; k < sizes.size(); ++k) {
        n[k + 1 - first] = std::strtoll(sizes[k].c_str(), nullptr, 10);
        if (n[k + 1 - first] < 1 || n[k + 1 - first] > 16384)
            return user_error(fmt::format("a side of {} is not possible", sizes[k]));
        numbers *= static_cast<size_t>(n[k + 1 - first]);
        if (numbers > (size_t{1} << 32)) return user_error("it is too large");
    }
    reader->channels = static_cast<int32_t>(n[0]);
    reader->size = {static_cast<int32_t>(n[1]), static_cast<int32_t>(n[2]),
                    static_cast<int32_t>(n[3])};
    if (Result<void> placed = place(fields, first, reader.get()); !placed) return placed.error();
    for (const char* name : {"data file", "datafile"}) {
        if (fields[name].empty()) continue;
        bytes = read_whole(file.parent_path() / fields[name]);
        if (!bytes)
            return user_error(fmt::format("its data file `{}` cannot be read", fields[name]));
        reader->begin = 0;
    }
    const std::string encoding = fields["encoding"];
    const size_t needed = numbers * static_cast<size_t>(reader->format.bytes);
    if (encoding == "gzip" || encoding == "gz") {
        bytes = unpack(*bytes, reader->begin, needed);
        if (!bytes) return bytes.error();
        reader->begin = 0;
    } else if (encoding == "ascii" || encoding == "text" || encoding == "txt") {
        reader->text = true;
    } else if (encoding != "raw") {
        return user_error(
            fmt::format("its encoding `{}` is not known; raw, text and gzip are", encoding));
    }
    if (!reader->text && bytes->size() - reader->begin < needed)
        return user_error("it is cut short");
    reader->bytes = std::move(*bytes);
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// VTK files that tests write, with their arrays as VTK's own writers put them.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/texture/field_test.h"

namespace openfab::tools {

inline std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        const size_t n = std::min<size_t>(3, bytes.size() - i);
        for (size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (k < n ? static_cast<uint8_t>(bytes[i + k]) : 0U);
        for (size_t k = 0; k < 4; ++k)
            out += k <= n ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

template <typename T>
std::string raw(T value) {
    std::string out(sizeof value, '\0');
    std::memcpy(out.data(), &value, sizeof value);
    return out;
}

/// How a file holds its arrays.
enum class Form { kText, kBase64, kPacked, kAppended, kAppendedBase64, kAppendedPacked };
inline constexpr std::array kForms{Form::kText,     Form::kBase64,         Form::kPacked,
                                   Form::kAppended, Form::kAppendedBase64, Form::kAppendedPacked};

/// Writes the parts of a VTK file.
class VtkWriter {
  public:
    explicit VtkWriter(Form form) : form_(form) {}

    template <typename T>
    std::string array(const std::string& name, const std::string& type, int components,
                      const std::vector<T>& values) {
        std::string tag = "<DataArray type=\"" + type + "\" Name=\"" + name +
                          "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"";
        // As VTK's writers put it behind the numbers of an array.
        const std::string end =
            "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"2\">"
            "<Value index=\"0\">0.5</Value><Value index=\"1\">7</Value></InformationKey>"
            "</DataArray>\n";
        std::string bytes;
        for (const T value : values)
            bytes += raw(value);
        switch (form_) {
            case Form::kText: {
                tag += "ascii\">\n";
                for (const T value : values)
                    tag += fmt::format("{} ", value);
                return tag + end;
            }
            case Form::kBase64:
                return tag + "binary\">\n  " + base64(raw<uint32_t>(bytes.size()) + bytes) + "\n" +
                       end;
            case Form::kPacked: {
                const auto [header, data] = packed(bytes);
                return tag + "binary\">" + base64(header) + base64(data) + end;
            }
            case Form::kAppended:
                tag += place();
                appended_ += raw<uint32_t>(bytes.size()) + bytes;
                return tag;
            case Form::kAppendedBase64:
                tag += place();
                appended_ += base64(raw<uint32_t>(bytes.size()) + bytes);
                return tag;
            case Form::kAppendedPacked:
                break;
        }
        tag += place();
        const auto [header, data] = packed(bytes);
        appended_ += header + data;
        return tag;
    }

    std::string file(const std::string& kind, const std::string& content) const {
        const bool is_packed = form_ == Form::kPacked || form_ == Form::kAppendedPacked;
        std::string out = "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + kind +
                          "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\"" +
                          (is_packed ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n" +
                          content;
        if (!appended_.empty()) {
            out += std::string("<AppendedData encoding=\"") +
                   (form_ == Form::kAppendedBase64 ? "base64" : "raw") + "\">\n  _" + appended_ +
                   "\n</AppendedData>\n";
        }
        return out + "</VTKFile>\n";
    }

  private:
    std::string place() const {
        return "appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
    }
    /// Blocks of 64 bytes, the last one shorter, as VTK writes them in larger ones.
    static std::pair<std::string, std::string> packed(const std::string& bytes) {
        constexpr size_t kBlock = 64;
        std::string sizes, data;
        const size_t blocks = (bytes.size() + kBlock - 1) / kBlock;
        for (size_t i = 0; i < blocks; ++i) {
            const std::string plain = bytes.substr(i * kBlock, kBlock);
            std::string out(compressBound(plain.size()), '\0');
            uLongf size = out.size();
            EXPECT_EQ(compress(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
                      Z_OK);
            data += out.substr(0, size);
            sizes += raw(static_cast<uint32_t>(size));
        }
        return {raw(static_cast<uint32_t>(blocks)) + raw(static_cast<uint32_t>(kBlock)) +
                    raw(static_cast<uint32_t>(bytes.size() % kBlock)) + sizes,
                data};
    }

    Form form_;
    std::string appended_;
};

inline std::string text_of(const BlockMesh& mesh, VtkWriter* writer, const std::string& fields) {
    const std::string places = writer->array("Points", "Float64", 3, mesh.points);
    const std::string cells = writer->array("connectivity", "Int64", 1, mesh.corners) +
                              writer->array("offsets", "Int64", 1, mesh.ends) +
                              writer->array("types", "UInt8", 1, mesh.types);
    return "<UnstructuredGrid><Piece NumberOfPoints=\"" + std::to_string(mesh.point_count()) +
           "\" NumberOfCells=\"" + std::to_string(mesh.types.size()) + "\">\n" + fields +
           "<Points>" + places + "</Points><Cells>" + cells +
           "</Cells></Piece></UnstructuredGrid>\n";
}

using VtkTest = FieldTest;

}  // namespace openfab::tools

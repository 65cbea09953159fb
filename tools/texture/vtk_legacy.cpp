// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// VTK's older files (.vtk), https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html: keywords
// in any case, each followed by numbers, as text or as big-endian bytes.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include "base/scan_number.h"
#include "base/text.h"
#include "tools/texture/messages.h"
#include "tools/texture/vtk_file.h"
#include "tools/texture/vtk_words.h"

namespace openfab::tools {

namespace {

constexpr int64_t kMostNumbers = int64_t{1} << 40;

struct TypeName {
    std::string_view name;
    ArrayType type;
    int64_t bytes;
};
// `long` is of 8 bytes where VTK runs today; `vtkidtype` is written as `int`.
constexpr std::array<TypeName, 16> kTypes{{
    {"char", ArrayType::kInt8, 1},
    {"signed_char", ArrayType::kInt8, 1},
    {"unsigned_char", ArrayType::kUInt8, 1},
    {"short", ArrayType::kInt16, 2},
    {"unsigned_short", ArrayType::kUInt16, 2},
    {"int", ArrayType::kInt32, 4},
    {"unsigned_int", ArrayType::kUInt32, 4},
    {"vtkidtype", ArrayType::kInt32, 4},
    {"long", ArrayType::kInt64, 8},
    {"unsigned_long", ArrayType::kUInt64, 8},
    {"long_long", ArrayType::kInt64, 8},
    {"unsigned_long_long", ArrayType::kUInt64, 8},
    {"vtktypeint64", ArrayType::kInt64, 8},
    {"vtktypeuint64", ArrayType::kUInt64, 8},
    {"float", ArrayType::kFloat32, 4},
    {"double", ArrayType::kFloat64, 8},
}};

constexpr int64_t kBitType = -1, kTextType = -2;

}  // namespace

class VtkFile::Legacy {
  public:
    explicit Legacy(VtkFile* file) : file_(*file), words_(file->file_) {}

    Result<void> read() {
        Result<void> done = head();
        for (std::string key; done;) {
            const Result<std::string> word = words_.word();
            if (!word) return word.error();
            if (word->empty()) break;
            key = lower_ascii(*word);
            done = take(key);
        }
        if (!done) {
            Error error = done.error();
            // Lines of bytes are not counted.
            if (!binary_)
                error.message = fmt::format(messages::kAtLine, words_.line(), error.message);
            return error;
        }
        if (file_.kind_.empty()) return user_error(messages::kNoDataSet);
        return {};
    }

  private:
    Result<void> head() {
        for (int line = 0; line < 2; ++line) {  // the version and a title
            if (const Result<std::string> passed = words_.rest_of_line(); !passed)
                return passed.error();
        }
        const Result<std::string> coding = words_.word();
        if (!coding) return coding.error();
        const std::string name = lower_ascii(*coding);
        if (name != "ascii" && name != "binary")
            return user_error(fmt::format(messages::kNeitherAsciiNorBinary, *coding));
        binary_ = name == "binary";
        return {};
    }

    Result<void> take(const std::string& key) {
        if (key == "dataset") return data_set();
        if (key == "dimensions") return dimensions();
        if (key == "origin") return numbers(3, file_.origin.data());
        if (key == "spacing" || key == "aspect_ratio") return numbers(3, file_.spacing.data());
        if (key == "points") return points();
        if (key == "x_coordinates" || key == "y_coordinates" || key == "z_coordinates")
            return places(key);
        if (key == "cells") return cells();
        if (key == "cell_types") return cell_types();
        if (key == "point_data" || key == "cell_data") {
            in_data_ = true;
            where_ = key == "point_data" ? Where::kPoints : Where::kCells;
            return count(&items_);
        }
        if (key == "field") return field();
        if (key == "metadata") return metadata();
        if (!in_data_) return unknown(key);
        if (key == "scalars") return scalars();
        if (key == "color_scalars") return colours();
        if (key == "lookup_table") return table();
        if (key == "texture_coordinates") return attribute(0);
        if (key == "vectors" || key == "normals") return attribute(3);
        if (key == "tensors") return attribute(9);
        if (key == "tensors6") return attribute(6);
        if (key == "global_ids" || key == "pedigree_ids" || key == "edge_flags")
            return attribute(1);
        return unknown(key);
    }

    static Result<void> unknown(const std::string& key) {
        return user_error(fmt::format(messages::kUnknownKeyword, key.substr(0, 40)));
    }

    Result<void> count(int64_t* out) {
        const Result<std::string> word = words_.word();
        if (!word) return word.error();
        const std::string wrong = scan_integer(*word, 0, kMostNumbers, out);
        return wrong.empty() ? Result<void>() : user_error(wrong);
    }
    Result<void> numbers(size_t many, double* out) {
        for (size_t i = 0; i < many; ++i) {
            const Result<std::string> word = words_.word();
            if (!word) return word.error();
            if (const std::string wrong = scan_number(*word, out++); !wrong.empty())
                return user_error(wrong);
        }
        return {};
    }

    Result<void> data_set() {
        const Result<std::string> word = words_.word();
        if (!word) return word.error();
        constexpr std::array<std::pair<std::string_view, const char*>, 4> kKinds{
            {{"structured_points", "ImageData"},
             {"rectilinear_grid", "RectilinearGrid"},
             {"structured_grid", "StructuredGrid"},
             {"unstructured_grid", "UnstructuredGrid"}}};
        const std::string name = lower_ascii(*word);
        for (const auto& [key, kind] : kKinds) {
            if (name == key) file_.kind_ = kind;
        }
        if (!file_.kind_.empty()) return {};
        if (name == "polydata") return user_error(messages::kIsASurface, messages::kIsASurfaceHelp);
        return user_error(fmt::format(messages::kDataSetNotRead, word->substr(0, 40)));
    }

    Result<void> dimensions() {
        std::array<int64_t, 3> n{};
        for (size_t a = 0; a < 3; ++a) {
            if (Result<void> got = count(&n[a]); !got) return got;
            file_.extent[2 * a] = 0;
            file_.extent[2 * a + 1] = static_cast<double>(n[a]) - 1;
        }
        return {};
    }

    /// Returns the type of this name, or one that is passed over.
    static Result<TypeName> type_of(const std::string& word) {
        const std::string name = lower_ascii(word);
        for (const TypeName& type : kTypes) {
            if (name == type.name) return type;
        }
        if (name == "bit") return TypeName{"bit", ArrayType::kUInt8, kBitType};
        if (name == "string" || name == "utf8_string")
            return TypeName{"string", ArrayType::kUInt8, kTextType};
        return user_error(fmt::format(messages::kUnknownNumberType, word.substr(0, 40)));
    }

    /// Reads the name of a type.
    Result<TypeName> type() {
        const Result<std::string> word = words_.word();
        if (!word) return word.error();
        return type_of(*word);
    }

    /// Passes over `count` numbers, which begin on the next line where they are bytes, and keeps where
    /// they are.
    Result<void> data(Array array, const TypeName& of, int64_t count, bool keep = true) {
        if (of.bytes == kTextType) return texts(count);
        array.type = of.type;
        array.total = count;
        array.coding = binary_ ? Coding::kBytes : Coding::kFileText;
        if (binary_) {
            if (Result<std::string> line = words_.rest_of_line(); !line) return line.error();
            const int64_t bytes = of.bytes == kBitType ? (count + 7) / 8 : count * of.bytes;
            if (bytes > words_.left()) return user_error(messages::kArrayCutShort);
            array.offset = words_.at();
            array.bytes = bytes;
            words_.go_to(array.offset + bytes);
        } else {
            if (2 * count - 1 > words_.left()) return user_error(messages::kArrayCutShort);
            array.offset = words_.at();
            for (int64_t i = 0; i < count; ++i) {
                const Result<std::string> word = words_.word();
                if (!word) return word.error();
                if (word->empty()) return user_error(messages::kArrayCutShort);
            }
            array.bytes = words_.at() - array.offset;
        }
        if (keep && of.bytes != kBitType) file_.arrays_.push_back(std::move(array));
        return {};
    }

    /// Passes over texts: lines, or each behind its length.
    Result<void> texts(int64_t count) {
        if (Result<std::string> line = words_.rest_of_line(); !line) return line.error();
        for (int64_t i = 0; i < count; ++i) {
            if (words_.left() <= 0) return user_error(messages::kArrayCutShort);
            if (!binary_) {
                if (Result<std::string> line = words_.rest_of_line(); !line) return line.error();
                continue;
            }
            std::array<unsigned char, 8> head{};
            const int64_t at = words_.at();
            const Result<size_t> got =
                file_.file_.read(at, reinterpret_cast<char*>(head.data()), head.size());
            if (!got) return got.error();
            // Its first two bits say of how many bytes the length is.
            const size_t size = size_t{1} << (3 - (head[0] >> 6));
            uint64_t length = head[0] & 0x3F;
            for (size_t k = 1; k < size; ++k)
                length = length << 8 | head[k];
            if (length > static_cast<uint64_t>(words_.left()) ||
                static_cast<int64_t>(size + length) > words_.left())
                return user_error(messages::kArrayCutShort);
            words_.go_to(at + static_cast<int64_t>(size + length));
        }
        return {};
    }

    Result<void> points() {
        if (Result<void> got = count(&file_.points); !got) return got;
        if (file_.points > INT32_MAX)
            return user_error(fmt::format(messages::kMoreThanPoints, INT32_MAX));
        const Result<TypeName> of = type();
        if (!of) return of.error();
        Array array;
        array.where = Where::kPlaces;
        array.components = 3;
        return data(array, *of, 3 * file_.points);
    }

    Result<void> places(const std::string& key) {
        int64_t many = 0;
        if (Result<void> got = count(&many); !got) return got;
        const Result<TypeName> of = type();
        if (!of) return of.error();
        Array array;
        array.where = Where::kAxes;
        array.name = key.substr(0, 1);
        return data(array, *of, many);
    }

    Result<void> cells() {
        int64_t many = 0, size = 0;
        if (Result<void> got = count(&many); !got) return got;
        if (Result<void> got = count(&size); !got) return got;
        if (many > INT32_MAX) return user_error(fmt::format(messages::kMoreThanCells, INT32_MAX));
        Array corners;
        corners.where = Where::kTopology;
        corners.name = "connectivity";
        Array ends = corners;
        ends.name = "offsets";
        const int64_t here = words_.at();
        const Result<std::string> word = binary_ ? words_.rest_of_line() : words_.word();
        if (!word) return word.error();
        std::string next = lower_ascii(*word);
        if (binary_) {
            // The next line is text where the newer form begins.
            const int64_t line = words_.at();
            std::array<char, 8> begin{};
            const Result<size_t> got = file_.file_.read(line, begin.data(), 7);
            if (!got) return got.error();
            next = lower_ascii(std::string(begin.data(), *got));
            if (next == "offsets") (void)words_.word();
        }
        if (next != "offsets") {
            // Each cell is a number of corners, and its corners.
            words_.go_to(here);
            file_.cells = many;
            ends.interleaved = corners.interleaved = true;
            const TypeName of{"int", ArrayType::kInt32, 4};
            if (Result<void> got = data(corners, of, size); !got) return got;
            ends.offset = file_.arrays_.back().offset;
            ends.bytes = file_.arrays_.back().bytes;
            ends.coding = file_.arrays_.back().coding;
            ends.total = size;
            ends.type = of.type;
            file_.arrays_.push_back(std::move(ends));
            return {};
        }
        if (many < 1) return user_error(messages::kNoCellOffsets);
        file_.cells = many - 1;
        const Result<TypeName> of = type();
        if (!of) return of.error();
        ends.skip = 1;  // the first is 0
        if (Result<void> got = data(ends, *of, many); !got) return got;
        const Result<std::string> key = words_.word();
        if (!key) return key.error();
        if (lower_ascii(*key) != "connectivity")
            return user_error(messages::kOffsetsWithoutConnectivity);
        const Result<TypeName> of_corners = type();
        if (!of_corners) return of_corners.error();
        return data(corners, *of_corners, size);
    }

    Result<void> cell_types() {
        int64_t many = 0;
        if (Result<void> got = count(&many); !got) return got;
        Array array;
        array.where = Where::kTopology;
        array.name = "types";
        return data(array, {"int", ArrayType::kInt32, 4}, many);
    }

    Result<std::string> name() {
        const Result<std::string> word = words_.word();
        if (!word) return word.error();
        return decoded_vtk_name(*word);
    }

    /// Reads an array of `components`, or of as many as it says where they are 0.
    Result<void> attribute(int64_t components) {
        const Result<std::string> called = name();
        if (!called) return called.error();
        if (components == 0) {
            if (Result<void> got = parts(*called, &components); !got) return got;
        }
        const Result<TypeName> of = type();
        if (!of) return of.error();
        return data(array_of(*called, components), *of, items_ * components);
    }
    Result<void> parts(const std::string& called, int64_t* components) {
        if (Result<void> got = count(components); !got) return got;
        return *components <= kMostParts ? Result<void>() : unusual(called);
    }
    static Error unusual(const std::string& called) {
        return user_error(fmt::format(messages::kUnusualComponents, called));
    }
    Array array_of(const std::string& called, int64_t components) const {
        Array array;
        array.where = where_;
        array.name = called;
        array.components = components;
        return array;
    }

    Result<void> scalars() {
        const Result<std::string> called = name();
        if (!called) return called.error();
        const Result<TypeName> of = type();
        if (!of) return of.error();
        // The number of components may stand behind the type, and a table of colours on the next line.
        const Result<std::string> rest = words_.rest_of_line();
        if (!rest) return rest.error();
        std::string_view left = *rest;
        const std::string_view many = take_word(&left);
        int64_t components = 1;
        if (!many.empty() && !scan_integer(many, 1, kMostParts, &components).empty())
            return unusual(*called);
        const int64_t here = words_.at();
        const Result<std::string> key = words_.word();
        if (!key) return key.error();
        if (lower_ascii(*key) == "lookup_table") {
            if (const Result<std::string> word = words_.word(); !word) return word.error();
        } else if (binary_) {
            return user_error(fmt::format(messages::kNoLookupTable, *called));
        } else {
            words_.go_to(here);
        }
        std::string& usual = where_ == Where::kPoints ? file_.point_scalars_ : file_.cell_scalars_;
        int& named = scalars_[where_ == Where::kPoints ? 0 : 1];
        usual = ++named == 1 ? *called : "";  // none where there are several
        return data(array_of(*called, components), *of, items_ * components);
    }

    Result<void> colours() {
        const Result<std::string> called = name();
        if (!called) return called.error();
        int64_t components = 0;
        if (Result<void> got = parts(*called, &components); !got) return got;
        // Bytes are 0 to 255, and so is what text has as 0 to 1: both are of one writer.
        const TypeName of = binary_ ? TypeName{"unsigned_char", ArrayType::kUInt8, 1}
                                    : TypeName{"float", ArrayType::kFloat32, 4};
        Array array = array_of(*called, components);
        constexpr double kWhite = 255;
        array.times = binary_ ? 1 : kWhite;
        return data(std::move(array), of, items_ * components);
    }

    Result<void> table() {
        if (const Result<std::string> word = words_.word(); !word) return word.error();
        int64_t many = 0;
        if (Result<void> got = count(&many); !got) return got;
        const TypeName of{"unsigned_char", ArrayType::kUInt8, 1};
        return data({}, of, 4 * many, false);
    }

    Result<void> field() {
        if (const Result<std::string> word = words_.word(); !word) return word.error();
        int64_t arrays = 0;
        if (Result<void> got = count(&arrays); !got) return got;
        for (int64_t i = 0; i < arrays; ++i) {
            Result<std::string> word = words_.word();
            while (word && lower_ascii(*word) == "metadata") {
                if (Result<void> passed = metadata(); !passed) return passed;
                word = words_.word();
            }
            if (!word) return word.error();
            if (word->empty()) return user_error(messages::kArrayCutShort);
            int64_t components = 0, tuples = 0;
            if (Result<void> got = parts(*word, &components); !got) return got;
            if (Result<void> got = count(&tuples); !got) return got;
            const Result<TypeName> of = type();
            if (!of) return of.error();
            const int64_t numbers = components * tuples;
            // Fields of the whole, as a time, are of no points and no cells.
            if (Result<void> got =
                    data(array_of(decoded_vtk_name(*word), components), *of, numbers, in_data_);
                !got)
                return got;
        }
        return {};
    }

    /// Passes over what ends with an empty line.
    Result<void> metadata() {
        if (const Result<std::string> line = words_.rest_of_line(); !line) return line.error();
        for (;;) {
            const bool at_end = words_.left() <= 0;
            const Result<std::string> line = words_.rest_of_line();
            if (!line) return line.error();
            if (at_end || line->empty()) return {};
        }
    }

    static constexpr int64_t kMostParts = 1000;

    VtkFile& file_;
    VtkWords words_;
    bool binary_ = false;
    bool in_data_ = false;
    Where where_ = Where::kPoints;
    int64_t items_ = 0;
    std::array<int, 2> scalars_{};
};

Result<void> VtkFile::read_legacy() {
    swapped_ = true;
    header_bytes_ = 0;
    return Legacy(this).read();
}

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/vtk_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/scan_number.h"
#include "base/xml.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kAppended = "<AppendedData";
constexpr size_t kAtOnce = 1 << 20;

/// What stands before the appended data, and where that begins.
struct Head {
    std::string text;
    int64_t appended_at = -1;  ///< offset of `<AppendedData`
};

Result<Head> read_head(const InputFile& file, const texture::ReadLimits& limits) {
    Head head;
    // With it lie the arrays' own text, and what is made of it.
    const int64_t most = limits.memory_bytes / 4;
    std::string piece(kAtOnce, '\0');
    for (int64_t at = 0;;) {
        const Result<size_t> got = file.read(at, piece.data(), piece.size());
        if (!got) return got.error();
        const size_t before = head.text.size();
        head.text.append(piece, 0, *got);
        const size_t from = before < kAppended.size() ? 0 : before - kAppended.size();
        const size_t found = head.text.find(kAppended, from);
        if (found != std::string::npos) {
            head.appended_at = static_cast<int64_t>(found);
            head.text.resize(found);
            return head;
        }
        if (*got == 0) return head;
        at += static_cast<int64_t>(*got);
        if (static_cast<int64_t>(head.text.size()) > most)
            return check_memory(4 * file.bytes(), limits.memory_bytes).error();
    }
}

/// Parses just as many numbers.
bool take_numbers(std::string_view text, double* out, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        if (!scan_number(take_word(&text), out++).empty()) return false;
    }
    return take_word(&text).empty();
}

constexpr std::array<std::string_view, 10> kTypes{
    "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Float32", "Float64"};

}  // namespace

/// Receives the elements of the head.
class VtkFile::Reading final : public XmlHandler {
  public:
    explicit Reading(VtkFile* file) : file_(*file) {}

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        if (depth_++ == 0) return root(name, a);
        if (name == file_.kind_ && name != "UnstructuredGrid") return image(a);
        if (name == "Piece") return piece(a);
        if (name == "PointData" || name == "CellData") {
            where_ = name == "PointData" ? Where::kPoints : Where::kCells;
            if (const char* scalars = a.find("Scalars"))
                (name == "PointData" ? file_.point_scalars_ : file_.cell_scalars_) = scalars;
            inside_ = true;
        } else if (name == "Points" || name == "Cells" || name == "Coordinates") {
            where_ = name == "Points"  ? Where::kPlaces
                     : name == "Cells" ? Where::kTopology
                                       : Where::kAxes;
            inside_ = true;
        } else if (name == "DataArray" && inside_) {
            return array(a);
        } else if (name == "AppendedData") {
            const char* encoding = a.find("encoding");
            file_.appended_base64_ = encoding != nullptr && std::string_view(encoding) == "base64";
        }
        return {};
    }
    void end(std::string_view name) override {
        --depth_;
        if (open_ == depth_ + 1) open_ = 0;
        if (name == "PointData" || name == "CellData" || name == "Points" || name == "Cells" ||
            name == "Coordinates")
            inside_ = false;
    }
    bool wants_text() const override { return true; }
    void text(std::string_view piece) override {
        // VTK writes elements of its own between the tags of an array (InformationKey).
        if (open_ > 0 && open_ == depth_) file_.arrays_.back().text += piece;
    }
    int pieces() const { return pieces_; }

  private:
    Complaint root(std::string_view name, const XmlAttributes& a) {
        const char* type = a.find("type");
        if (name != "VTKFile" || type == nullptr) return {messages::kNotVtkXml};
        constexpr std::array<std::string_view, 4> kKinds{"ImageData", "RectilinearGrid",
                                                         "StructuredGrid", "UnstructuredGrid"};
        if (std::find(kKinds.begin(), kKinds.end(), type) == kKinds.end()) {
            return {fmt::format(messages::kVtkKindNotRead, type),
                    type == std::string_view("PolyData") ? messages::kVtkSurfaceHelp
                                                         : messages::kVtkKindNotReadHelp};
        }
        file_.kind_ = type;
        if (const char* order = a.find("byte_order"))
            file_.swapped_ = std::string_view(order) == "BigEndian";
        if (const char* header = a.find("header_type"))
            file_.header_bytes_ = std::string_view(header) == "UInt64" ? 8 : 4;
        if (const char* compressor = a.find("compressor");
            compressor != nullptr && *compressor != 0) {
            file_.packed_ = true;
            if (std::string_view(compressor) != "vtkZLibDataCompressor")
                file_.unknown_packer_ = compressor;
        }
        return {};
    }
    Complaint image(const XmlAttributes& a) {
        const auto read = [&](const char* key, double* out, size_t count) {
            const char* text = a.find(key);
            return text == nullptr || take_numbers(text, out, count);
        };
        if (!read("WholeExtent", file_.extent.data(), 6) ||
            !read("Origin", file_.origin.data(), 3) || !read("Spacing", file_.spacing.data(), 3) ||
            !read("Direction", file_.direction.data(), 9))
            return {messages::kExtentMalformed};
        return {};
    }
    Complaint piece(const XmlAttributes& a) {
        if (++pieces_ > 1) return {messages::kSeveralPieces, messages::kSeveralPiecesHelp};
        const char* extent = a.find("Extent");
        if (extent != nullptr && !take_numbers(extent, file_.extent.data(), 6))
            return {messages::kPieceExtentMalformed};
        const auto count = [&](const char* key, int64_t* out) {
            const char* text = a.find(key);
            return text == nullptr || scan_integer(text, 0, INT32_MAX, out).empty();
        };
        if (!count("NumberOfPoints", &file_.points) || !count("NumberOfCells", &file_.cells))
            return {fmt::format(messages::kPointsAndCellsOutside, INT32_MAX)};
        return {};
    }
    Complaint array(const XmlAttributes& a) {
        Array out;
        out.where = where_;
        if (const char* name = a.find("Name")) out.name = name;
        const char* type = a.find("type");
        const auto* const known =
            std::find(kTypes.begin(), kTypes.end(), std::string_view(type == nullptr ? "" : type));
        if (known == kTypes.end()) return {};  // text, of which no field is made
        out.type = static_cast<ArrayType>(known - kTypes.begin());
        if (const char* n = a.find("NumberOfComponents");
            n != nullptr && !scan_integer(n, 1, 1000, &out.components).empty())
            return {fmt::format(messages::kUnusualComponents, out.name)};
        const char* format = a.find("format");
        const std::string_view coding = format == nullptr ? "ascii" : format;
        out.coding = coding == "appended" ? Coding::kAppended
                     : coding == "binary" ? Coding::kBase64
                                          : Coding::kText;
        if (const char* offset = a.find("offset");
            offset != nullptr && !scan_integer(offset, 0, INT64_MAX / 2, &out.offset).empty())
            return {fmt::format(messages::kOffsetNotWhole, out.name)};
        file_.arrays_.push_back(std::move(out));
        open_ = depth_;
        return {};
    }

    VtkFile& file_;
    int depth_ = 0, pieces_ = 0;
    Where where_ = Where::kPoints;
    bool inside_ = false;  ///< of one of the groups of arrays
    int open_ = 0;         ///< depth of an array; 0: in none
};

Result<std::unique_ptr<VtkFile>> VtkFile::open(const fs::path& path,
                                               const texture::ReadLimits& limits) {
    Result<InputFile> opened = InputFile::open(path);
    if (!opened) return opened.error();
    std::unique_ptr<VtkFile> out(
        new VtkFile(std::move(*opened), path.filename().string(), limits.memory_bytes));
    std::string begin(kLegacyVtk.size(), '\0');
    const Result<size_t> got = out->file_.read(0, begin.data(), begin.size());
    if (!got) return got.error();
    const Result<void> read = begin == kLegacyVtk ? out->read_legacy() : out->read_xml(limits);
    if (!read) return read.error();
    return out;
}

Result<void> VtkFile::read_xml(const texture::ReadLimits& limits) {
    Result<Head> head = read_head(file_, limits);
    if (!head) return head.error();
    if (head->appended_at >= 0) {
        // Its raw bytes are no XML: the tag is read as an empty one, the last.
        std::string tag(4096, '\0');
        const Result<size_t> got = file_.read(head->appended_at, tag.data(), tag.size());
        if (!got) return got.error();
        tag.resize(*got);
        const size_t end = tag.find('>');
        const size_t mark = tag.find('_', std::min(end, tag.size()));
        if (end == std::string::npos || mark == std::string::npos)
            return user_error(messages::kAppendedDataMissingStart);
        appended_at_ = head->appended_at + static_cast<int64_t>(mark) + 1;
        head->text += tag.substr(0, end) + "/></VTKFile>";
    }
    Reading reading(this);
    if (Result<void> parsed = parse_xml(head->text, {}, &reading); !parsed) {
        Error error = parsed.error();
        if (error.location.line > 0)
            error.message = fmt::format(messages::kAtLine, error.location.line, error.message);
        error.location = {};
        return error;
    }
    if (reading.pieces() == 0) return user_error(messages::kNoPiece);
    return {};
}

Result<const VtkFile::Array*> VtkFile::field(const std::string& name) const {
    std::vector<const Array*> fields;
    for (const Where where : {Where::kPoints, Where::kCells}) {
        for (const Array& array : arrays_) {
            if (array.where != where) continue;
            const bool is_ghost = array.name == "vtkGhostType" || array.name == "vtkGhostLevels";
            if (is_ghost && array.name != name) {
                tell(fmt::format(messages::kGhostsLeftOut, name_, array.name));
            } else {
                fields.push_back(&array);
            }
        }
    }
    std::vector<std::string> names;
    names.reserve(fields.size());
    for (const Array* array : fields)
        names.push_back(array->name);
    const Result<size_t> picked =
        pick_field(names, name, !point_scalars_.empty() ? point_scalars_ : cell_scalars_);
    if (!picked) return picked.error();
    return fields[*picked];
}

Result<const VtkFile::Array*> VtkFile::part(Where where, const std::string& name) const {
    for (const Array& array : arrays_) {
        if (array.where == where && (name.empty() || array.name == name)) return &array;
    }
    return user_error(name.empty() ? messages::kNoPoints
                                   : fmt::format(messages::kNoArrayOfCells, name));
}

Result<std::array<const VtkFile::Array*, 3>> VtkFile::axes() const {
    std::array<const Array*, 3> out{};
    size_t found = 0;
    for (const Array& array : arrays_) {
        if (array.where != Where::kAxes) continue;
        if (found < out.size()) out[found] = &array;
        ++found;
    }
    if (found != out.size()) return user_error(fmt::format(messages::kAxesArrays, found));
    return out;
}

Result<std::unique_ptr<ArrayNumbers>> VtkFile::numbers(const Array& array, int64_t count) const {
    if (array.coding == Coding::kFileText || array.coding == Coding::kBytes)
        return legacy_numbers(array, count);
    if (array.coding == Coding::kText) return open_array_text(array.text, count);
    if (!unknown_packer_.empty()) {
        return user_error(fmt::format(messages::kPackedBy, unknown_packer_),
                          messages::kPackedByHelp);
    }
    ArrayBytes bytes;
    bytes.swapped = swapped_;
    bytes.header_bytes = header_bytes_;
    bytes.packed = packed_;
    if (array.coding == Coding::kBase64) {
        bytes.text = array.text;
        bytes.base64 = true;
    } else {
        if (appended_at_ < 0) return user_error(messages::kAppendedDataMissing);
        bytes.file = &file_;
        bytes.begin = appended_at_ + array.offset;
        bytes.base64 = appended_base64_;
    }
    return open_array_bytes(bytes, array.type, count);
}

}  // namespace openfab::tools

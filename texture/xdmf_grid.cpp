// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/xdmf_grid.h"

#include <fmt/format.h>

#include <set>
#include <string_view>

#include "base/scan_number.h"
#include "base/text.h"
#include "base/units.h"
#include "base/xml.h"

namespace openfab::texture {

namespace {

constexpr int64_t kMostNumbers = int64_t{1} << 40;
constexpr const char* kPlain = "write the file with its data as XML or Binary, or as a .vtu";

/// Returns an attribute in lower case, under either of its names.
std::string word_of(const XmlAttributes& a, std::string_view name, std::string_view other = {}) {
    const char* value = a.find(name);
    if (value == nullptr && !other.empty()) value = a.find(other);
    return value == nullptr ? std::string() : lower_ascii(std::string(value));
}

/// Parses whole numbers from 1, whose product is kept within bounds.
bool read_sizes(const char* text, std::vector<int64_t>* sizes, int64_t* product) {
    std::string_view left = text == nullptr ? "" : text;
    *product = 1;
    for (std::string_view word = take_word(&left); !word.empty(); word = take_word(&left)) {
        int64_t size = 0;
        if (!scan_integer(word, 1, kMostNumbers / *product, &size).empty()) return false;
        *product *= size;
        sizes->push_back(size);
    }
    return !sizes->empty();
}

/// Reads what kind of numbers an item has.
Complaint read_kind(const XmlAttributes& a, XdmfItem* item) {
    std::string type = word_of(a, "NumberType", "DataType");
    int64_t bytes = 4;
    if (const char* precision = a.find("Precision");
        precision != nullptr && !scan_integer(precision, 1, 8, &bytes).empty())
        return fmt::format("its precision is `{}`; 1, 2, 4 or 8 bytes are possible", precision);
    if (type == "char" || type == "uchar") bytes = 1;
    if (type == "short" || type == "ushort") bytes = 2;
    const bool is_float = type.empty() || type == "float";
    const bool is_unsigned = type == "uint" || type == "uchar" || type == "ushort";
    if (!is_float && !is_unsigned && type != "int" && type != "char" && type != "short")
        return fmt::format("its numbers are of type `{}`, which is not known", type);
    if ((bytes & (bytes - 1)) != 0 || (is_float && bytes < 4))
        return fmt::format("numbers of {} bytes are not known", bytes);
    item->kind = is_float      ? XdmfItem::Kind::kFloat
                 : is_unsigned ? XdmfItem::Kind::kUnsigned
                               : XdmfItem::Kind::kSigned;
    item->bytes = static_cast<int>(bytes);
    return {};
}

Complaint read_item(const XmlAttributes& a, XdmfItem* item) {
    if (const std::string type = word_of(a, "ItemType"); !type.empty() && type != "uniform")
        return {fmt::format("it is computed of others (`{}`)", type), kPlain};
    if (a.find("Reference") != nullptr)
        return {"it is a reference to another", "write the numbers where they are used"};
    const std::string format = word_of(a, "Format");
    if (!format.empty() && format != "xml" && format != "binary" && format != "hdf")
        return {fmt::format("its format `{}` is not known", format), kPlain};
    item->place = format == "binary" ? XdmfItem::Place::kDataFile
                  : format == "hdf"  ? XdmfItem::Place::kHdf
                                     : XdmfItem::Place::kHere;
    if (const std::string packed = word_of(a, "Compression"); !packed.empty() && packed != "raw")
        return {fmt::format("it is compressed by `{}`", packed), "write it not compressed"};
    item->big_endian = word_of(a, "Endian") == "big";
    if (const char* seek = a.find("Seek");
        seek != nullptr && !scan_integer(seek, 0, INT64_MAX / 2, &item->seek).empty())
        return fmt::format("its `Seek` is `{}`, no number of bytes", seek);
    if (!read_sizes(a.find("Dimensions"), &item->sizes, &item->count))
        return {"its `Dimensions` are not whole numbers from 1, or too large"};
    return read_kind(a, item);
}

/// Receives the elements.
class Reading final : public XmlHandler {
  public:
    explicit Reading(XdmfGrid* grid) : grid_(*grid) {}

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        ++depth_;
        if (depth_ == 1 && name != "Xdmf") return {"it is not an XDMF file"};
        if (skipped_ > 0) return {};
        if (name == "Grid") return grid(a);
        if (grid_depth_ == 0) return {};
        if (name == "include") return include(a);
        if (depth_ == grid_depth_ + 1) {
            const bool of_mesh = name == "Topology" || name == "Geometry";
            if (grids_ == 2 && (mesh_is_first() ? of_mesh : name == "Attribute")) return several();
            part(name, a);
        }
        if (name == "DataItem" && items_ != nullptr) {
            // Items within another are what it is computed of.
            if (item_depth_ > 0) return {};
            constexpr int kMostItems = 10'000;
            if (++count_ > kMostItems)
                return {fmt::format("its grid has more than {} arrays", kMostItems)};
            item_depth_ = depth_;
            items_->emplace_back();
            items_->back().wrong = read_item(a, &items_->back());
        }
        return {};
    }
    void end(std::string_view) override {
        if (skipped_ == depth_) skipped_ = 0;
        if (item_depth_ == depth_) item_depth_ = 0;
        if (grid_depth_ > 0 && depth_ == grid_depth_ + 1) end_part();
        if (grid_depth_ == depth_) grid_depth_ = 0;
        if (!series_.empty() && series_.back() == depth_) series_.pop_back();
        --depth_;
    }
    bool wants_text() const override { return true; }
    void text(std::string_view piece) override {
        if (item_depth_ > 0 && item_depth_ == depth_ && items_->back().wrong.empty())
            items_->back().text += piece;
    }
    /// Says what is missing at the end.
    Complaint missing() const {
        if (grids_ == 0) return {"it has no grid"};
        if (grids_ == 1 && includer_ != 0) return not_there();
        return grids_ == 2 && includer_ == 0 ? several() : Complaint();
    }

  private:
    static Complaint several() {
        return {"it has several grids", "merge them, or write each as a file of its own"};
    }
    static Complaint not_there() {
        return {
            "its grid takes parts by `xi:include` that are not cells and points of the one other "
            "grid",
            "write the grid with its own Topology, Geometry and Attribute"};
    }
    /// Solvers write a mesh as a grid without fields, before or after a series whose steps take cells
    /// and points of it.
    Complaint include(const XmlAttributes& a) {
        const char* const pointer = a.find("xpointer");
        const std::string_view what = pointer == nullptr ? "" : pointer;
        if (includer_ != 0 || a.find("href") != nullptr ||
            what.find("Topology") == std::string_view::npos ||
            what.find("Geometry") == std::string_view::npos)
            return not_there();
        includer_ = grids_;
        return {};
    }
    bool mesh_is_first() const { return includer_ != 1; }
    Complaint grid(const XmlAttributes& a) {
        const bool is_step = !series_.empty() && series_.back() == depth_ - 1;
        if (is_step && ++steps_ > 1) {
            skipped_ = depth_;
            return {};
        }
        const std::string type = word_of(a, "GridType", "Type");
        if (type == "collection" && word_of(a, "CollectionType") == "temporal") {
            if (!series_.empty()) return {"it has series of steps within each other"};
            series_.push_back(depth_);
            steps_ = 0;
            return {};
        }
        if (type == "collection" || type == "tree") return {};
        if (!type.empty() && type != "uniform")
            return {fmt::format("it has a grid of type `{}`", type), "write a Uniform one"};
        if (grids_ == 2 || (grids_ == 1 && mesh_is_first() && !grid_.fields.empty()))
            return several();
        ++grids_;
        grid_depth_ = depth_;
        return {};
    }
    /// Begins a child of the grid.
    void part(std::string_view name, const XmlAttributes& a) {
        if (name == "Topology") {
            grid_.topology = word_of(a, "TopologyType", "Type");
            const char* sizes = a.find("NumberOfElements");
            if (sizes == nullptr) sizes = a.find("Dimensions");
            grid_.points_along.clear();
            if (!read_sizes(sizes, &grid_.points_along, &grid_.cells))
                grid_.wrong_topology = {"its topology does not say how many elements it has"};
            if (const char* base = a.find("BaseOffset");
                base != nullptr && !scan_integer(base, 0, INT32_MAX, &grid_.first_point).empty())
                grid_.wrong_topology = {"its `BaseOffset` is not a whole number"};
            if (a.find("Order") != nullptr)
                grid_.wrong_topology = {"its corners are in an order of their own",
                                        "write it without `Order`"};
            items_ = &grid_.cell_items;
        } else if (name == "Geometry") {
            grid_.geometry = word_of(a, "GeometryType", "Type");
            items_ = &grid_.point_items;
        } else if (name == "Attribute") {
            const std::string center = word_of(a, "Center");
            is_field_ = center.empty() || center == "node" || center == "cell";
            if (!is_field_) return;
            field_ = {};
            if (const char* text = a.find("Name")) field_.name = text;
            field_.of_points = center != "cell";
            field_items_.clear();
            items_ = &field_items_;
        }
    }
    void end_part() {
        if (is_field_ && !field_items_.empty()) {
            field_.item = std::move(field_items_.front());
            grid_.fields.push_back(std::move(field_));
        }
        is_field_ = false;
        items_ = nullptr;
    }

    XdmfGrid& grid_;
    int depth_ = 0;
    int skipped_ = 0, grid_depth_ = 0, item_depth_ = 0;  ///< of the element; 0: in none
    std::vector<int> series_;                            ///< depth of a collection of steps
    int steps_ = 0, count_ = 0;
    bool is_field_ = false;
    int grids_ = 0;
    int includer_ = 0;  ///< which of them takes cells and points of the other; 0: none
    XdmfField field_;
    std::vector<XdmfItem> field_items_;
    std::vector<XdmfItem>* items_ = nullptr;  ///< of the part at hand
};

/// Leaves the name of a data file without the blanks around it, and of a set.
void trim(XdmfItem* item) {
    constexpr std::string_view kBlanks = " \t\r\n";
    if (item->place == XdmfItem::Place::kHere) return;
    const size_t begin = item->text.find_first_not_of(kBlanks);
    const size_t end = item->text.find_last_not_of(kBlanks);
    item->text = begin == std::string::npos ? "" : item->text.substr(begin, end + 1 - begin);
    if (item->place == XdmfItem::Place::kHdf) {
        const size_t colon = std::min(item->text.find(":/"), item->text.rfind(':'));
        item->set = colon == std::string::npos ? "" : item->text.substr(colon + 1);
        item->text.resize(item->set.empty() ? 0 : colon);
    }
    if (item->wrong.empty() && item->text.empty()) item->wrong = {"it names no data file"};
}

}  // namespace

bool is_xdmf(const std::filesystem::path& file) {
    const std::string kind = lower_ascii(file.extension().string());
    return kind == ".xdmf" || kind == ".xmf";
}

bool XdmfGrid::has_hdf() const {
    const auto is_hdf = [](const XdmfItem& item) { return item.place == XdmfItem::Place::kHdf; };
    return std::any_of(cell_items.begin(), cell_items.end(), is_hdf) ||
           std::any_of(point_items.begin(), point_items.end(), is_hdf) ||
           std::any_of(fields.begin(), fields.end(),
                       [&](const XdmfField& field) { return is_hdf(field.item); });
}

std::vector<std::string> XdmfGrid::data_files() const {
    std::vector<std::string> out;
    std::set<std::string> known;
    const auto add = [&](const XdmfItem& item) {
        if (item.place != XdmfItem::Place::kHere && item.wrong.empty() &&
            known.insert(item.text).second)
            out.push_back(item.text);
    };
    for (const XdmfItem& item : cell_items)
        add(item);
    for (const XdmfItem& item : point_items)
        add(item);
    for (const XdmfField& field : fields)
        add(field.item);
    return out;
}

Result<XdmfGrid> read_xdmf_grid(const InputFile& file, const ReadLimits& limits) {
    // With it lie the texts of the items, and what is made of them.
    const int64_t most = limits.memory_bytes / 4;
    if (file.bytes() > most) {
        return user_error(
            fmt::format("it is {} of text, more than a quarter of the {} of `--memory`",
                        format_bytes(file.bytes()), format_bytes(limits.memory_bytes)),
            "write its data as Binary, or raise it");
    }
    const Result<std::string> text = file.read_all(most);
    if (!text) return text.error();
    XdmfGrid grid;
    Reading reading(&grid);
    if (Result<void> parsed = parse_xml(*text, {}, &reading); !parsed) {
        Error error = parsed.error();
        if (error.location.line > 0)
            error.message = fmt::format("line {}: {}", error.location.line, error.message);
        error.location = {};
        return error;
    }
    if (const Complaint missing = reading.missing(); !missing.empty())
        return user_error(missing.what, missing.help);
    for (std::vector<XdmfItem>* items : {&grid.cell_items, &grid.point_items}) {
        for (XdmfItem& item : *items)
            trim(&item);
    }
    for (XdmfField& field : grid.fields)
        trim(&field.item);
    return grid;
}

}  // namespace openfab::texture

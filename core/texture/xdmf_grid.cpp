// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/xdmf_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "base/scan_number.h"
#include "base/text.h"
#include "base/units.h"
#include "base/xml.h"
#include "texture/messages.h"
#include "texture/xdmf_steps.h"

namespace openfab::texture {

namespace {

constexpr int64_t kMostNumbers = int64_t{1} << 40;

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
    std::string type = xdmf_word(a, "NumberType", "DataType");
    int64_t bytes = 4;
    if (const char* precision = a.find("Precision");
        precision != nullptr && !scan_integer(precision, 1, 8, &bytes).empty())
        return fmt::format(messages::kPrecisionUnknown, precision);
    if (type == "char" || type == "uchar") bytes = 1;
    if (type == "short" || type == "ushort") bytes = 2;
    const bool is_float = type.empty() || type == "float";
    const bool is_unsigned = type == "uint" || type == "uchar" || type == "ushort";
    if (!is_float && !is_unsigned && type != "int" && type != "char" && type != "short")
        return fmt::format(messages::kNumberTypeUnknown, type);
    if ((bytes & (bytes - 1)) != 0 || (is_float && bytes < 4))
        return fmt::format(messages::kNumberBytesUnknown, bytes);
    item->kind = is_float      ? XdmfItem::Kind::kFloat
                 : is_unsigned ? XdmfItem::Kind::kUnsigned
                               : XdmfItem::Kind::kSigned;
    item->bytes = static_cast<int>(bytes);
    return {};
}

Complaint read_item(const XmlAttributes& a, XdmfItem* item) {
    if (const std::string type = xdmf_word(a, "ItemType"); !type.empty() && type != "uniform")
        return {fmt::format(messages::kItemComputed, type), messages::kWritePlain};
    if (a.find("Reference") != nullptr)
        return {messages::kItemReference, messages::kItemReferenceHelp};
    const std::string format = xdmf_word(a, "Format");
    if (!format.empty() && format != "xml" && format != "binary" && format != "hdf")
        return {fmt::format(messages::kItemFormatUnknown, format), messages::kWritePlain};
    item->place = format == "binary" ? XdmfItem::Place::kDataFile
                  : format == "hdf"  ? XdmfItem::Place::kHdf
                                     : XdmfItem::Place::kHere;
    if (const std::string packed = xdmf_word(a, "Compression"); !packed.empty() && packed != "raw")
        return {fmt::format(messages::kItemCompressed, packed), messages::kItemCompressedHelp};
    item->big_endian = xdmf_word(a, "Endian") == "big";
    if (const char* seek = a.find("Seek");
        seek != nullptr && !scan_integer(seek, 0, INT64_MAX / 2, &item->seek).empty())
        return fmt::format(messages::kSeekNoNumber, seek);
    if (!read_sizes(a.find("Dimensions"), &item->sizes, &item->count))
        return {messages::kSizesNotWhole};
    return read_kind(a, item);
}

/// Parses the three rows of a slab, and checks it against its array and the item's `Dimensions`.
Complaint read_slab(std::string_view text, std::vector<int64_t> sizes, XdmfItem* item) {
    XdmfSlab slab;
    slab.sizes = std::move(sizes);
    int64_t product = 1;
    for (std::vector<int64_t>* row : {&slab.start, &slab.stride, &slab.count}) {
        for (const int64_t size : slab.sizes) {
            const int64_t least = row == &slab.start ? 0 : 1;
            int64_t& number = row->emplace_back();
            if (!scan_integer(take_word(&text), least, size, &number).empty())
                return messages::kSlabRowsMissing;
        }
    }
    for (size_t a = 0; a < slab.sizes.size(); ++a) {
        const int64_t room = slab.sizes[a] - 1 - slab.start[a], steps = slab.count[a] - 1;
        if (room < 0 || (steps > 0 && slab.stride[a] > room / steps)) {
            return fmt::format(messages::kSlabBeyondArray, slab.sizes[a]);
        }
        product *= slab.count[a];  // of parts of the array's sides, whose product is in bounds
    }
    if (product != item->count || !take_word(&text).empty())
        return fmt::format(messages::kSlabCountDiffers, product, item->count);
    item->slab = std::move(slab);
    return {};
}

/// Receives the elements.
class Reading final : public XmlHandler {
  public:
    /// Reads this step.
    Reading(XdmfGrid* grid, const XdmfStep& step)
        : grid_(*grid), wanted_series_(step.series), wanted_step_(step.step) {}

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        ++depth_;
        if (depth_ == 1 && name != "Xdmf") return {messages::kNotXdmf};
        if (skipped_ > 0) return {};
        // The array at hand would end with a part of the inner grid.
        if (name == "Grid" && item_depth_ > 0) return {messages::kGridInArray};
        if (name == "Grid") return grid(a);
        if (grid_depth_ == 0) return {};
        if (name == "include") return include(a);
        if (depth_ == grid_depth_ + 1) {
            const bool of_mesh = name == "Topology" || name == "Geometry";
            if (!in_first_step_ && grids_ == 2 && (mesh_is_first() ? of_mesh : name == "Attribute"))
                return several();
            part(name, a);
        }
        if (name == "DataItem" && items_ != nullptr) {
            if (item_depth_ > 0) {
                if (depth_ == item_depth_ + 1) part_of_slab(a);
                return {};
            }
            constexpr int kMostItems = 10'000;
            if (++count_ > kMostItems) return {fmt::format(messages::kTooManyArrays, kMostItems)};
            item_depth_ = depth_;
            items_->emplace_back();
            begin_item(a);
        }
        return {};
    }
    void end(std::string_view) override {
        if (skipped_ == depth_) skipped_ = 0;
        if (item_depth_ > 0 && item_depth_ == depth_) {
            end_item();
            item_depth_ = 0;
        }
        if (grid_depth_ > 0 && depth_ == grid_depth_ + 1) end_part();
        if (grid_depth_ == depth_) grid_depth_ = 0;
        if (!series_.empty() && series_.back() == depth_) series_.pop_back();
        if (in_first_step_ && !series_.empty() && series_.back() == depth_ - 1)
            in_first_step_ = false;
        --depth_;
    }
    bool wants_text() const override { return true; }
    bool allows_document_type() const override { return true; }
    void text(std::string_view piece) override {
        if (item_depth_ == 0 || !items_->back().wrong.empty()) return;
        if (!is_slab_ && item_depth_ == depth_) items_->back().text += piece;
        if (is_slab_ && item_depth_ + 1 == depth_ && slab_parts_ == 1) slab_text_ += piece;
        if (is_slab_ && item_depth_ + 1 == depth_ && slab_parts_ == 2) source_.text += piece;
    }
    /// Ends the grid. Says what is missing of it.
    Complaint finish() {
        const bool has_first = first_grids_ == 1 && !first_.topology.empty();
        if (grids_ == 0) return {messages::kNoGrid};
        grid_.steps = std::max(steps_, 1);
        if (includer_ != 0 && has_first == (grids_ == 2)) return not_there();
        if (includer_ != 0 && has_first) {
            first_.fields = std::move(grid_.fields);
            first_.steps = grid_.steps;
            grid_ = std::move(first_);
        }
        return grids_ == 2 && includer_ == 0 ? several() : Complaint();
    }

  private:
    static Complaint several() { return {messages::kSeveralGrids, messages::kSeveralGridsHelp}; }
    static Complaint not_there() {
        return {messages::kIncludeElsewhere, messages::kIncludeElsewhereHelp};
    }
    /// Solvers write a mesh as a grid without fields, before or after a series whose steps take cells
    /// and points of it.
    Complaint include(const XmlAttributes& a) {
        if (in_first_step_) return {};  // then the wanted step includes the same
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
        if (is_step) {
            const int step = steps_++;
            // Later steps may take cells and points of it.
            in_first_step_ = step == 0 && wanted_step_ > 0;
            if (step != wanted_step_ && !in_first_step_) {
                skipped_ = depth_;
                return {};
            }
        }
        const std::string type = xdmf_word(a, "GridType", "Type");
        if (type == "collection" && xdmf_word(a, "CollectionType") == "temporal") {
            if (!series_.empty()) return {messages::kSeriesNested};
            if (series_count_++ != wanted_series_) {
                skipped_ = depth_;
                return {};
            }
            series_.push_back(depth_);
            steps_ = 0;
            return {};
        }
        if (type == "collection" || type == "tree") return {};
        if (!type.empty() && type != "uniform")
            return {fmt::format(messages::kGridTypeUnknown, type), messages::kGridTypeUnknownHelp};
        if (in_first_step_) {
            first_grids_++ == 0 ? grid_depth_ = depth_ : skipped_ = depth_;
            return {};
        }
        if (grids_ == 2 || (grids_ == 1 && mesh_is_first() && !grid_.fields.empty()))
            return several();
        ++grids_;
        grid_depth_ = depth_;
        return {};
    }
    /// Begins an array: one that is written, or a part of one (a HyperSlab), which stands within it
    /// behind the numbers that say which part.
    void begin_item(const XmlAttributes& a) {
        XdmfItem& item = items_->back();
        is_slab_ = xdmf_word(a, "ItemType") == "hyperslab";
        slab_parts_ = 0;
        slab_text_.clear();
        source_ = {};
        if (!is_slab_) {
            item.wrong = read_item(a, &item);
        } else if (!read_sizes(a.find("Dimensions"), &item.sizes, &item.count)) {
            item.wrong = messages::kSizesNotWhole;
        }
    }
    void part_of_slab(const XmlAttributes& a) {
        XdmfItem& item = items_->back();
        if (!is_slab_ || !item.wrong.empty()) return;
        ++slab_parts_;
        const std::string format = xdmf_word(a, "Format");
        if (slab_parts_ == 1 && !format.empty() && format != "xml")
            item.wrong = {messages::kSlabNumbersElsewhere};
        if (slab_parts_ == 2) item.wrong = read_item(a, &source_);
    }
    void end_item() {
        XdmfItem& item = items_->back();
        if (!is_slab_ || !item.wrong.empty()) return;
        if (slab_parts_ != 2) {
            item.wrong = {messages::kSlabWithoutTwoItems};
            return;
        }
        source_.count = item.count;
        std::swap(source_.sizes, item.sizes);
        const std::vector<int64_t> whole = std::move(item.sizes);
        item = std::move(source_);
        item.wrong = read_slab(slab_text_, whole, &item);
    }
    /// Begins a child of the grid.
    void part(std::string_view name, const XmlAttributes& a) {
        XdmfGrid& into = in_first_step_ ? first_ : grid_;
        if (name == "Topology") {
            into.topology = xdmf_word(a, "TopologyType", "Type");
            const char* sizes = a.find("NumberOfElements");
            if (sizes == nullptr) sizes = a.find("Dimensions");
            into.points_along.clear();
            if (!read_sizes(sizes, &into.points_along, &into.cells))
                into.wrong_topology = {messages::kTopologyWithoutCount};
            if (const char* base = a.find("BaseOffset");
                base != nullptr && !scan_integer(base, 0, INT32_MAX, &into.first_point).empty())
                into.wrong_topology = {messages::kBaseOffsetNotWhole};
            if (a.find("Order") != nullptr)
                into.wrong_topology = {messages::kCornersOrdered, messages::kCornersOrderedHelp};
            refuse_reference(name, a, &into);
            items_ = &into.cell_items;
        } else if (name == "Geometry") {
            refuse_reference(name, a, &into);
            into.geometry = xdmf_word(a, "GeometryType", "Type");
            items_ = &into.point_items;
        } else if (name == "Attribute" && !in_first_step_) {
            const std::string center = xdmf_word(a, "Center");
            // As FEniCS writes them, apart from the values at nodes.
            const bool is_function = xdmf_word(a, "ItemType") == "finiteelementfunction";
            is_field_ = center.empty() || center == "node" || center == "cell" || is_function;
            if (!is_field_) return;
            field_ = {};
            if (const char* text = a.find("Name")) field_.name = text;
            if (is_function)
                field_.item.wrong = {messages::kElementFunction, messages::kElementFunctionHelp};
            field_.of_points = center != "cell";
            field_items_.clear();
            items_ = &field_items_;
        }
    }
    static void refuse_reference(std::string_view name, const XmlAttributes& a, XdmfGrid* into) {
        if (a.find("Reference") != nullptr)
            into->wrong_topology = {fmt::format(messages::kPartReference, name),
                                    messages::kPartReferenceHelp};
    }
    void end_part() {
        if (is_field_ && !field_items_.empty()) {
            Complaint wrong = std::move(field_.item.wrong);
            field_.item = std::move(field_items_.front());
            if (!wrong.empty()) field_.item.wrong = std::move(wrong);
            grid_.fields.push_back(std::move(field_));
        }
        is_field_ = false;
        items_ = nullptr;
    }

    XdmfGrid& grid_;
    const int wanted_series_, wanted_step_;
    int series_count_ = 0;        ///< so far
    bool in_first_step_ = false;  ///< while another one is wanted
    XdmfGrid first_;              ///< its cells and points
    int first_grids_ = 0;
    bool is_slab_ = false;  ///< the item at hand
    int slab_parts_ = 0;    ///< items within it so far
    std::string slab_text_;
    XdmfItem source_;  ///< the array of which it is a part
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

/// Whether a second series may follow: then the file is read once more, before the rest.
bool may_have_several_series(std::string_view text) {
    constexpr std::string_view kTemporal = "temporal";
    const auto find = [&](size_t from) {
        const auto* const found = std::search(text.begin() + static_cast<std::ptrdiff_t>(from),
                                              text.end(), kTemporal.begin(), kTemporal.end(),
                                              [](char a, char b) { return (a | 0x20) == b; });
        return static_cast<size_t>(found - text.begin());
    };
    const size_t first = find(0);
    return first < text.size() && find(first + 1) < text.size();
}

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
    if (item->wrong.empty() && item->text.empty()) item->wrong = {messages::kNoDataFile};
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

Result<XdmfGrid> read_xdmf_grid(const InputFile& file, std::optional<double> time,
                                const std::string& field, const ReadLimits& limits) {
    // With it lie the texts of the items, and what is made of them.
    const int64_t most = limits.memory_bytes / 4;
    if (file.bytes() > most) {
        return user_error(fmt::format(messages::kXmlTooLarge, format_bytes(file.bytes()),
                                      format_bytes(limits.memory_bytes)),
                          messages::kXmlTooLargeHelp);
    }
    const Result<std::string> text = file.read_all(most);
    if (!text) return text.error();
    const auto at_line = [](Error error) {
        if (error.location.line > 0)
            error.message = fmt::format(messages::kAtLine, error.location.line, error.message);
        error.location = {};
        return error;
    };
    XdmfStep step;
    if (time || may_have_several_series(*text)) {
        const Result<XdmfStep> found = find_xdmf_step(*text, time, field);
        if (!found) return at_line(found.error());
        step = *found;
    }
    XdmfGrid grid;
    Reading reading(&grid, step);
    if (Result<void> parsed = parse_xml(*text, {}, &reading); !parsed)
        return at_line(parsed.error());
    if (const Complaint missing = reading.finish(); !missing.empty())
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

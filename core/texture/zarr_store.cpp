// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/zarr_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/json.h"
#include "base/units.h"
#include "texture/messages.h"
#include "texture/named_length.h"
#include "texture/nrrd_header.h"

namespace openfab::texture {

namespace {

namespace fs = std::filesystem;
using Kind = JsonValue::Kind;

constexpr const char* kVersion3 = "zarr.json";
constexpr const char* kArray2 = ".zarray";
constexpr const char* kGroup2 = ".zgroup";
constexpr const char* kAttributes2 = ".zattrs";

/// Whether there is something of this name, be it a link that leads nowhere.
bool is_there(const fs::path& file) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(file, ignored));
}

const JsonValue* member(const JsonValue* value, const char* key) {
    const JsonMember* const found = value != nullptr ? value->find(key) : nullptr;
    return found != nullptr ? &found->value : nullptr;
}

/// A group or an array.
struct Node {
    std::string path;  ///< from the store on, with a slash behind it
    std::string name;  ///< of the file that says so
    int version = 3;
    bool is_array = false;
    JsonValue json;
    JsonValue attributes2;  ///< of version 2

    const JsonValue* attributes() const {
        return version == 3 ? member(&json, "attributes") : &attributes2;
    }
    /// Where OME's metadata are: since 0.5 below a key of their own.
    const JsonValue* ome() const {
        const JsonValue* const own = member(attributes(), "ome");
        return own != nullptr ? own : attributes();
    }
};

struct Axis {
    std::string name, type, unit;
};

struct Level {
    std::string path;
    std::vector<double> scale, translation;  ///< by axis; the second may be empty
};

/// Reads a store; what it finds goes to a volume.
class StoreReader {
  public:
    StoreReader(const fs::path& file, const VolumeOptions& options, const ReadLimits& limits)
        : file_(file), folder_(file.parent_path()), options_(options), limits_(limits) {}

    Result<ZarrVolume> read() {
        std::string wanted = options_.field;
        while (wanted.ends_with('/'))
            wanted.pop_back();
        if (wanted.starts_with('/') || ("/" + wanted + "/").find("/../") != std::string::npos)
            return user_error(fmt::format(messages::kZarrField, options_.field));
        Result<Node> root = read_node("");
        if (!root) return root.error();
        volume_.print = member(root->attributes(), "openfab") != nullptr;
        if (Result<void> done = read_part(*root, wanted); !done) return done.error();
        return std::move(volume_);
    }

  private:
    Result<JsonValue> read_json(const std::string& name) {
        constexpr int64_t kMostBytes = 16 << 20;
        const Result<InputFile> file = open_data_file(file_, name, limits_);
        if (!file) return file.error();
        const Result<std::string> text = file->read_all(kMostBytes);
        if (!text) return with_context(text.error(), fmt::format(messages::kZarrUnread, name));
        volume_.metadata.push_back(name);
        Result<JsonValue> json = parse_json(*text, name, limits_.memory_bytes);
        if (json && !json->is(Kind::kObject))
            return user_error(fmt::format(messages::kZarrNoObject, name));
        return json;
    }

    /// Reads the node in a folder of the store: empty, or with a slash behind it.
    Result<Node> read_node(const std::string& path) {
        Node node;
        node.path = path;
        const auto there = [&](const char* name) { return is_there(folder_ / (path + name)); };
        if (there(kVersion3)) {
            node.name = path + kVersion3;
        } else {
            node.version = 2;
            node.is_array = there(kArray2);
            node.name = path + (node.is_array ? kArray2 : kGroup2);
            if (!node.is_array && !there(kGroup2) && !there(kAttributes2))
                return user_error(fmt::format(messages::kZarrNoNode, path));
            if (there(kAttributes2)) {
                Result<JsonValue> attributes = read_json(path + kAttributes2);
                if (!attributes) return attributes.error();
                node.attributes2 = std::move(*attributes);
            }
            if (!node.is_array && !there(kGroup2)) return node;
        }
        Result<JsonValue> json = read_json(node.name);
        if (!json) return json.error();
        node.json = std::move(*json);
        const JsonValue* const format = member(&node.json, "zarr_format");
        if (format == nullptr || format->whole() != node.version)
            return user_error(
                fmt::format(messages::kZarrVersion, node.name,
                            format != nullptr ? fmt::format("{}", format->number) : "?"));
        const JsonValue* const type = member(&node.json, "node_type");
        if (node.version == 3) node.is_array = type != nullptr && type->text == "array";
        return node;
    }

    Result<void> read_part(const Node& root, const std::string& wanted) {
        const JsonValue* const scales = member(root.ome(), "multiscales");
        if (scales != nullptr && !scales->items.empty() && !root.is_array)
            return read_image(root, scales->items[0], wanted);
        if (!wanted.empty()) {
            const Result<Node> part = read_node(wanted + "/");
            if (!part) return part.error();
            return read_part(*part, "");
        }
        if (!root.is_array)
            return user_error(fmt::format(messages::kZarrGroup, root.name),
                              messages::kZarrGroupHelp);
        return take_plain(root);
    }

    /// Chooses the level of an image of OME.
    Result<void> read_image(const Node& root, const JsonValue& image, const std::string& wanted) {
        const Result<std::vector<Axis>> axes = read_axes(root, image);
        if (!axes) return axes.error();
        Result<std::vector<Level>> levels = read_levels(root, image, axes->size());
        if (!levels) return levels.error();
        size_t level = 0;
        bool found = wanted.empty();
        for (size_t l = 0; l < levels->size() && !found; ++l) {
            level = l;
            found = (*levels)[l].path == wanted;
        }
        if (!found) {
            const Result<Node> part = read_node(wanted + "/");
            if (!part) return part.error();
            return read_part(*part, "");
        }
        if (Result<void> placed = take_axes(*axes); !placed) return placed;
        volume_.labels = member(root.ome(), "image-label") != nullptr;
        const Result<std::array<double, 3>> units = units_mm(*axes);
        if (!units) return units.error();
        for (const Level& one : *levels) {
            double longest = 0;
            for (size_t a = 0; a < 3; ++a)
                longest = std::max(longest, one.scale[volume_.axes[a]] * (*units)[a]);
            volume_.levels_mm.push_back(longest);
        }
        if (wanted.empty() && options_.pitch_mm > 0) {
            // Rounding of a scale must not change the level.
            constexpr double kRounding = 1 + 1e-6;
            for (size_t l = 0; l < levels->size(); ++l) {
                const double mm = volume_.levels_mm[l];
                const bool fits = mm <= options_.pitch_mm * kRounding;
                if (fits && mm > volume_.levels_mm[level]) level = l;
            }
        }
        volume_.level = level;
        const Level& chosen = (*levels)[level];
        const Result<Node> array = read_node(root.path + chosen.path + "/");
        if (!array) return array.error();
        if (Result<void> taken = take_array(*array, axes->size()); !taken) return taken;
        volume_.lengths = true;
        volume_.spacing.emplace();
        for (size_t a = 0; a < 3; ++a)
            (*volume_.spacing)[a] = chosen.scale[volume_.axes[a]] * (*units)[a];
        if (chosen.translation.empty()) return {};
        volume_.origin.emplace();
        for (size_t a = 0; a < 3; ++a)
            (*volume_.origin)[a] =
                chosen.translation[volume_.axes[a]] * (*units)[a] - (*volume_.spacing)[a] / 2;
        return {};
    }

    Result<std::vector<Axis>> read_axes(const Node& root, const JsonValue& image) const {
        const JsonValue* const list = member(&image, "axes");
        std::vector<Axis> axes;
        // Of 0.1 and 0.2.
        if (list == nullptr)
            return std::vector<Axis>{{"t", "time", ""},
                                     {"c", "channel", ""},
                                     {"z", "space", ""},
                                     {"y", "space", ""},
                                     {"x", "space", ""}};
        for (const JsonValue& item : list->items) {
            const auto text = [&](const char* key) {
                const JsonValue* const value = member(&item, key);
                return value != nullptr ? value->text : std::string();
            };
            if (item.is(Kind::kString)) {
                axes.push_back({item.text, "", ""});
            } else {
                axes.push_back({text("name"), text("type"), text("unit")});
            }
        }
        constexpr size_t kMostAxes = 8;
        if (axes.size() > kMostAxes)
            return user_error(
                fmt::format(messages::kZarrAt, root.name, list->line, messages::kZarrAxesOfImage));
        return axes;
    }

    /// Reads the numbers of a transformation, one for each axis.
    static bool numbers(const JsonValue* list, size_t axes, std::vector<double>* out) {
        if (list == nullptr || list->items.size() != axes) return false;
        for (const JsonValue& item : list->items) {
            if (!item.is(Kind::kNumber) || !std::isfinite(item.number)) return false;
            out->push_back(item.number);
        }
        return true;
    }

    /// Applies the transformations of a level or of all of them.
    Result<void> transform(const Node& root, const JsonValue* list, size_t axes,
                           Level* level) const {
        if (list == nullptr) return {};
        for (const JsonValue& item : list->items) {
            const JsonValue* const type = member(&item, "type");
            const std::string kind = type != nullptr ? type->text : "?";
            std::vector<double> values;
            const auto fail = [&](const std::string& what) {
                return user_error(fmt::format(messages::kZarrAt, root.name, item.line, what));
            };
            if (kind == "identity") continue;
            if (kind != "scale" && kind != "translation")
                return fail(fmt::format(messages::kZarrTransform, kind));
            if (!numbers(member(&item, kind.c_str()), axes, &values))
                return fail(fmt::format(messages::kZarrTransformNumbers, kind, axes));
            if (kind == "scale") {
                for (size_t a = 0; a < axes; ++a) {
                    if (!(values[a] > 0)) return fail(messages::kZarrScale);
                    level->scale[a] *= values[a];
                    if (!level->translation.empty()) level->translation[a] *= values[a];
                }
            } else {
                level->translation.resize(axes);
                for (size_t a = 0; a < axes; ++a)
                    level->translation[a] += values[a];
            }
        }
        return {};
    }

    Result<std::vector<Level>> read_levels(const Node& root, const JsonValue& image,
                                           size_t axes) const {
        constexpr size_t kMostLevels = 64;
        const JsonValue* const sets = member(&image, "datasets");
        std::vector<Level> out;
        if (sets == nullptr || sets->items.empty() || sets->items.size() > kMostLevels)
            return user_error(
                fmt::format(messages::kZarrAt, root.name, image.line, messages::kZarrNoLevels));
        for (const JsonValue& set : sets->items) {
            const JsonValue* const path = member(&set, "path");
            Level level{path != nullptr ? path->text : "", std::vector<double>(axes, 1), {}};
            if (level.path.empty() || level.path.starts_with('/') ||
                ("/" + level.path + "/").find("/../") != std::string::npos)
                return user_error(fmt::format(messages::kZarrAt, root.name, set.line,
                                              fmt::format(messages::kZarrField, level.path)));
            for (const JsonValue* list : {member(&set, "coordinateTransformations"),
                                          member(&image, "coordinateTransformations")}) {
                if (Result<void> done = transform(root, list, axes, &level); !done)
                    return done.error();
            }
            out.push_back(std::move(level));
        }
        return out;
    }

    /// Notes which axes are x, y, z and of channels.
    Result<void> take_axes(const std::vector<Axis>& axes) {
        std::array<bool, 3> seen{};
        for (size_t a = 0; a < axes.size(); ++a) {
            const std::string& name = axes[a].name;
            const size_t space = std::string_view("xyz").find(name);
            if (name.size() == 1 && space != std::string_view::npos && !seen[space]) {
                seen[space] = true;
                volume_.axes[space] = a;
            } else if (axes[a].type == "channel" || name == "c") {
                if (volume_.channels) return user_error(messages::kZarrAxesOfImage);
                volume_.channels = a;
            }
        }
        if (!seen[0] || !seen[1] || !seen[2]) return user_error(messages::kZarrAxesOfImage);
        return {};
    }

    Result<std::array<double, 3>> units_mm(const std::vector<Axis>& axes) {
        std::array<double, 3> out{1, 1, 1};
        for (size_t a = 0; a < 3; ++a) {
            const std::string& unit = axes[volume_.axes[a]].unit;
            volume_.unit_given = volume_.unit_given || !unit.empty();
            if (!options_.unit.empty()) {
                const Result<double> mm = parse_length_mm("1" + options_.unit);
                if (mm) out[a] = *mm;
            } else if (!unit.empty()) {
                const std::optional<double> mm = named_length_mm(unit);
                if (!mm)
                    return user_error(fmt::format(messages::kZarrUnit, unit),
                                      messages::kZarrUnitHelp);
                out[a] = *mm;
            }
        }
        return out;
    }

    /// Takes an array that says nothing of its axes but, perhaps, their names.
    Result<void> take_plain(const Node& node) {
        if (Result<void> taken = take_array(node, 0); !taken) return taken;
        const ZarrArray& array = volume_.array;
        std::vector<Axis> axes;
        for (const std::string& name : array.names)
            axes.push_back({name, "", ""});
        const auto named = [&](const char* name) {
            return std::count(array.names.begin(), array.names.end(), name) == 1;
        };
        if (named("x") && named("y") && named("z")) return take_axes(axes);
        const size_t sides = array.shape.size();
        if (sides != 3 && sides != 4)
            return user_error(fmt::format(messages::kZarrSides, node.name, sides),
                              messages::kZarrSidesHelp);
        volume_.axes = {2, 1, 0};
        if (sides == 4) volume_.channels = 3;
        return {};
    }

    /// `axes`: how many it must have; 0: any.
    Result<void> take_array(const Node& node, size_t axes) {
        if (!node.is_array) return user_error(fmt::format(messages::kZarrNoArray, node.path));
        Result<ZarrArray> array = node.version == 3 ? read_zarr3_array(node.json, node.name)
                                                    : read_zarr2_array(node.json, node.name);
        if (!array) return array.error();
        if (axes != 0 && array->shape.size() != axes)
            return user_error(
                fmt::format(messages::kZarrSidesDiffer, node.name, array->shape.size(), axes));
        volume_.path = node.path;
        volume_.array = std::move(*array);
        return {};
    }

    const fs::path& file_;
    fs::path folder_;
    const VolumeOptions& options_;
    const ReadLimits& limits_;
    ZarrVolume volume_;
};

/// Refuses what lies along axes that are not of space.
Result<void> check_axes(const ZarrVolume& volume) {
    const ZarrArray& array = volume.array;
    for (size_t a = 0; a < array.shape.size(); ++a) {
        const bool space =
            std::find(volume.axes.begin(), volume.axes.end(), a) != volume.axes.end();
        if (space || array.shape[a] == 1) continue;
        if (volume.channels == a) {
            constexpr int64_t kMostChannels = 4;
            if (array.shape[a] <= kMostChannels) continue;
            return user_error(fmt::format(messages::kZarrChannels, array.shape[a]),
                              messages::kZarrChannelsHelp);
        }
        return user_error(fmt::format(messages::kZarrOtherAxis, a, array.shape[a]),
                          messages::kZarrOtherAxisHelp);
    }
    return {};
}

}  // namespace

std::array<int64_t, 4> ZarrVolume::sides() const {
    return {array.shape[axes[0]], array.shape[axes[1]], array.shape[axes[2]],
            channels ? array.shape[*channels] : 1};
}

fs::path zarr_metadata(const fs::path& folder) {
    for (const char* name : {kVersion3, kArray2, kGroup2, kAttributes2}) {
        std::error_code ignored;
        if (fs::is_regular_file(folder / name, ignored)) return folder / name;
    }
    return {};
}

bool is_zarr_metadata(const fs::path& file) {
    const std::string name = file.filename().string();
    return name == kVersion3 || name == kArray2 || name == kGroup2 || name == kAttributes2;
}

Result<ZarrVolume> read_zarr_store(const fs::path& file, const VolumeOptions& options,
                                   const ReadLimits& limits) {
    Result<ZarrVolume> volume = StoreReader(file, options, limits).read();
    if (!volume) return volume;
    if (Result<void> fits = check_axes(*volume); !fits) return fits.error();
    return volume;
}

Result<std::vector<int64_t>> zarr_file_counts(const ZarrVolume& volume) {
    const ZarrArray& array = volume.array;
    constexpr double kMostFiles = 1e6;
    std::vector<int64_t> counts;
    double all = 1;
    for (size_t a = 0; a < array.shape.size(); ++a) {
        counts.push_back((array.shape[a] - 1) / array.file[a] + 1);
        all *= static_cast<double>(counts.back());
    }
    if (all > kMostFiles)
        return user_error(fmt::format(messages::kZarrTooManyFiles, all, kMostFiles),
                          messages::kZarrTooManyFilesHelp);
    return counts;
}

bool next_place(const std::vector<int64_t>& counts, std::vector<int64_t>* at) {
    for (size_t a = counts.size(); a-- > 0;) {
        if (++(*at)[a] < counts[a]) return true;
        (*at)[a] = 0;
    }
    return false;
}

Result<std::vector<std::string>> zarr_files(const fs::path& file, const ZarrVolume& volume) {
    const Result<std::vector<int64_t>> counts = zarr_file_counts(volume);
    if (!counts) return counts.error();
    std::vector<std::string> out = volume.metadata;
    std::vector<int64_t> at(counts->size(), 0);
    do {
        std::string name = volume.path + volume.array.file_name(at);
        if (is_there(file.parent_path() / name)) out.push_back(std::move(name));
    } while (next_place(*counts, &at));
    return out;
}

}  // namespace openfab::texture

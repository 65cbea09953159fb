// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/build_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "base/affine.h"
#include "base/keyed_hash.h"
#include "base/near_miss.h"
#include "base/polar.h"
#include "base/rotation.h"
#include "world/messages.h"
#include "world/transforms_file.h"
#include "world/uniform_values.h"

namespace openfab::world {
namespace {

using Kind = JsonValue::Kind;

constexpr double kLargestScale = 1e6;
/// Limit of the placements kept while nested groups are flattened.
constexpr size_t kMostMade = 5 * kMostPlacements;
constexpr int kDeepest = 64;

/// Reads one number for all axes, or one for each.
Vec3d one_or_three(const JsonValue& value, const std::string& what, double least, double most,
                   JsonReader* json) {
    if (value.is(Kind::kNumber)) {
        const double n = json->number(value, what, least, most);
        return {n, n, n};
    }
    const std::vector<double> n = json->numbers(value, what, 3, most);
    for (size_t i = 0; i < 3 && json->ok(); ++i) {
        if (n[i] < least)
            json->fail(value.items[i], fmt::format("{} has {:.6g}", what, n[i]),
                       fmt::format(messages::kAtLeast, least));
    }
    return {n[0], n[1], n[2]};
}

std::vector<std::string> object_names(const World& world) {
    std::vector<std::string> names;
    for (const Object& object : world.objects)
        names.push_back(object.name);
    return names;
}

/// Bytes that a placement takes for one of its overrides.
size_t binding_bytes(const std::string& name, const UniformBinding& binding) {
    constexpr size_t kNode = 96;  // of the map, and small texts
    size_t bytes = sizeof binding + kNode + name.size() + binding.location.file.size();
    if (const auto* numbers = std::get_if<std::vector<double>>(&binding.value))
        bytes += numbers->size() * sizeof(double);
    if (const auto* names = std::get_if<std::vector<std::string>>(&binding.value)) {
        for (const std::string& text : *names)
            bytes += sizeof text + text.size();
    }
    if (const auto* curve = std::get_if<Curve>(&binding.value)) {
        for (const std::vector<double>& key : curve->keys)
            bytes += sizeof key + key.size() * sizeof(double);
    }
    return bytes;
}

void move(const Vec3d& by, std::vector<Placement>* placements) {
    for (Placement& p : *placements)
        p.transform.t = p.transform.t + by;
}

}  // namespace

BuildReader::BuildReader(JsonReader* json, WorldFiles* files, World* world, int64_t memory_bytes,
                         ExtentOf extent_of)
    : json_(*json),
      files_(*files),
      world_(*world),
      memory_bytes_(memory_bytes),
      extent_of_(std::move(extent_of)) {
    for (size_t i = 0; i < world_.objects.size(); ++i)
        objects_[world_.objects[i].name] = static_cast<int32_t>(i);
}

void BuildReader::read(const JsonValue* groups, const JsonValue& build,
                       const JsonValue* arrange_as) {
    if (!json_.ok()) return;
    if (groups != nullptr) {
        if (!json_.named_things(*groups, "groups")) return;
        for (const JsonMember& m : groups->members)
            groups_[m.key].items = &m.value;
        // Unused ones, too, so that errors in them are reported.
        for (const JsonMember& m : groups->members) {
            JsonValue name;
            name.kind = Kind::kString;
            name.text = m.key;
            name.line = m.line;
            name.column = m.column;
            group(name, "`groups`");
        }
    }
    std::vector<std::vector<Placement>> all = each_item(build, "build");
    if (arrange_as != nullptr && json_.ok()) arrange(*arrange_as, &all);
    for (std::vector<Placement>& item : all)
        std::move(item.begin(), item.end(), std::back_inserter(world_.build));
    if (written_.changed() > 0) {
        world_.warnings.push_back(
            fmt::format(messages::kTransformsAlikeToFour, written_.changed()));
    }
}

std::vector<Placement> BuildReader::items(const JsonValue& list, const std::string& what) {
    std::vector<Placement> out;
    for (std::vector<Placement>& item : each_item(list, what))
        std::move(item.begin(), item.end(), std::back_inserter(out));
    return out;
}

std::vector<std::vector<Placement>> BuildReader::each_item(const JsonValue& list,
                                                           const std::string& what) {
    std::vector<std::vector<Placement>> out;
    if (!json_.ok()) return out;
    if (!list.is(Kind::kArray) || list.items.empty()) {
        json_.fail(
            list,
            fmt::format("`{}` is {}", what, list.is(Kind::kArray) ? "empty" : list.kind_name()),
            messages::kMustBePlacements);
        return out;
    }
    size_t count = 0;
    for (size_t i = 0; i < list.items.size() && json_.ok(); ++i) {
        out.emplace_back();
        placement(list.items[i], fmt::format("{}[{}]", what, i), &out.back());
        count += out.back().size();
        if (!room_for(list.items[i], count)) break;
    }
    return out;
}

/// Arranges items in rows along x, front to back, on the bed, ignoring their own positions. Rows
/// begin at x = y = 0, or are centered there if that is the tray's center.
void BuildReader::arrange(const JsonValue& value, std::vector<std::vector<Placement>>* items) {
    const std::string name = "`arrange`";
    if (!json_.object(value, world_keys("arrange"), name)) return;
    const int32_t columns = json_.integer(value.find("columns")->value, "`columns` of " + name, 1,
                                          static_cast<int32_t>(kMostPlacements));
    const double spacing =
        json_.number(value.find("spacing_mm")->value, "`spacing_mm` of " + name, 0, kFarthest_mm);
    if (!json_.ok()) return;
    double x = 0, y = 0, depth = 0, width = 0;
    for (size_t i = 0; i < items->size(); ++i) {
        if (i > 0 && i % static_cast<size_t>(columns) == 0) {
            x = 0;
            y += depth + spacing;
            depth = 0;
        }
        const Box3d of = box(value, (*items)[i]);
        move({x - of.lo.x, y - of.lo.y, 0 - of.lo.z}, &(*items)[i]);
        width = std::max(width, x + of.size().x);
        x += of.size().x + spacing;
        depth = std::max(depth, of.size().y);
    }
    if (world_.tray != Tray::kCenter) return;
    for (std::vector<Placement>& item : *items)
        move({width / -2, (y + depth) / -2, 0}, &item);
}

bool BuildReader::room_for(const JsonValue& value, size_t count) {
    if (!json_.ok()) return false;
    if (count <= kMostPlacements) return true;
    json_.fail(value, fmt::format(messages::kTooManyPlacements, count),
               fmt::format(messages::kAtMost, kMostPlacements));
    return false;
}

/// Returns whether that many copies fit in memory; each copies its uniform overrides.
bool BuildReader::memory_for(const JsonValue& value, const std::vector<Placement>& placements,
                             size_t copies) {
    if (!json_.ok()) return false;
    double bytes = 0;
    for (const Placement& p : placements) {
        size_t one = sizeof p + p.location.file.size();
        for (const auto& [name, binding] : p.overrides)
            one += binding_bytes(name, binding);
        bytes += static_cast<double>(one);
    }
    return take_memory(value, bytes * static_cast<double>(copies));
}

bool BuildReader::take_memory(const JsonValue& value, double bytes) {
    made_bytes_ += bytes;
    if (made_bytes_ <= static_cast<double>(memory_bytes_)) return true;
    json_.fail(value,
               fmt::format(messages::kPlacementsTakeTooMuch, made_bytes_ / 1e6,
                           static_cast<double>(memory_bytes_) / 1e6),
               messages::kAllowMoreMemory);
    return false;
}

/// Scale and rotation, then placement on the bed, then copies.
void BuildReader::placement(const JsonValue& value, const std::string& what,
                            std::vector<Placement>* out) {
    if (!json_.object(value, world_keys("placement"), what)) return;
    std::vector<Placement> placed = subject(value, what);
    const Local local = transform(value, what);
    if (!json_.ok()) return;
    for (Placement& p : placed)
        p.transform = product(local.transform, p.transform);
    if (local.on_bed) move({0, 0, 0 - box(value, placed).lo.z}, &placed);
    const JsonMember* many = value.find("grid");
    const JsonMember* file = value.find("transforms");
    if (many != nullptr && file != nullptr) {
        return json_.fail_at(file->line, file->column,
                             fmt::format(messages::kGridAndTransforms, what),
                             messages::kOneOrTheOther);
    }
    if (many != nullptr) grid(many->value, what, &placed);
    if (file != nullptr) copies(file->value, what, &placed);
    made_ += placed.size();
    if (made_ > kMostMade)
        return json_.fail(value, fmt::format(messages::kGroupsHoldTooMuch, kMostMade));
    if (!room_for(value, out->size() + placed.size())) return;
    out->insert(out->end(), std::make_move_iterator(placed.begin()),
                std::make_move_iterator(placed.end()));
}

/// The object or group, with the overrides of its uniforms, in its own space.
std::vector<Placement> BuildReader::subject(const JsonValue& value, const std::string& what) {
    const JsonMember* object = value.find("object");
    const JsonMember* of_group = value.find("group");
    if ((object != nullptr) == (of_group != nullptr)) {
        json_.fail(
            value,
            fmt::format("{} has {}", what,
                        object != nullptr ? messages::kObjectAndGroup : messages::kNoObjectNoGroup),
            messages::kNoObjectNoGroupHelp);
        return {};
    }
    const JsonMember* uniforms = value.find("uniforms");
    if (of_group != nullptr) {
        UniformBindings overrides;
        if (uniforms != nullptr) overrides = read_uniforms(uniforms->value, what, &json_);
        std::vector<Placement> out =
            named_group(of_group->value, fmt::format("`group` of {}", what), overrides);
        if (!memory_for(value, out, 1)) return {};
        if (uniforms != nullptr) override_group(uniforms->value, what, overrides, &out);
        return out;
    }
    const std::string name = json_.string(object->value, fmt::format("`object` of {}", what));
    const auto found = objects_.find(name);
    if (json_.ok() && found == objects_.end())
        json_.fail(object->value, fmt::format(messages::kNoSuchObject, name),
                   suggest(name, object_names(world_)));
    if (!json_.ok()) return {};
    Placement placement;
    placement.object = found->second;
    placement.location = json_.location(value);
    if (uniforms != nullptr) placement.overrides = read_uniforms(uniforms->value, what, &json_);
    return with_pieces(value, what, std::move(placement));
}

/// The placements of a group. Those that overrides may give other extents are read anew: where they
/// stand may depend on them.
std::vector<Placement> BuildReader::named_group(const JsonValue& value, const std::string& what,
                                                const UniformBindings& overrides) {
    Group* group = this->group(value, what);
    if (group == nullptr) return {};
    const bool depends = extent_of_ != nullptr &&
                         (!overrides.empty() || !outer_overrides_.empty()) &&
                         std::ranges::any_of(group->placements,
                                             [&](const Placement& p) { return has_own_extent(p); });
    if (!depends) {
        if (group->no_extent) note_no_extent(*group->no_extent);
        return group->placements;
    }
    outer_overrides_.push_back(overrides);
    std::vector<Placement> out = group_items(value, group);
    outer_overrides_.pop_back();
    return out;
}

BuildReader::Group* BuildReader::group(const JsonValue& value, const std::string& what) {
    const std::string name = json_.string(value, what);
    if (!json_.ok()) return nullptr;
    const auto found = groups_.find(name);
    if (found == groups_.end()) {
        std::vector<std::string> names;
        for (const auto& [known, group] : groups_)
            names.push_back(known);
        json_.fail(value, fmt::format(messages::kNoSuchGroup, name),
                   names.empty() ? messages::kNoGroups : suggest(name, names));
        return nullptr;
    }
    Group& group = found->second;
    if (group.state == Group::kBeingRead) {
        json_.fail(value, fmt::format(messages::kGroupHoldsItself, name));
        return nullptr;
    }
    if (group.state == Group::kUnread) {
        // As it is without overrides.
        std::vector<UniformBindings> outer;
        outer.swap(outer_overrides_);
        std::optional<Error> before;
        before.swap(no_extent_);
        group.placements = group_items(value, &group);
        group.no_extent = std::move(no_extent_);
        before.swap(no_extent_);
        outer.swap(outer_overrides_);
    }
    return json_.ok() ? &group : nullptr;
}

std::vector<Placement> BuildReader::group_items(const JsonValue& value, Group* group) {
    if (depth_ == kDeepest) {
        json_.fail(value, fmt::format(messages::kGroupNestedTooDeep, value.text, kDeepest));
        return {};
    }
    ++depth_;
    group->state = Group::kBeingRead;
    std::vector<Placement> out = items(*group->items, fmt::format("groups.{}", value.text));
    group->state = Group::kRead;
    --depth_;
    return out;
}

/// A group's overrides name the object: `"pin.height": 3`.
void BuildReader::override_group(const JsonValue& value, const std::string& what,
                                 const UniformBindings& bindings,
                                 std::vector<Placement>* placements) {
    std::unordered_map<int32_t, std::vector<size_t>, KeyedHash> of_object;
    std::vector<std::string> names;
    for (size_t i = 0; i < placements->size(); ++i) {
        std::vector<size_t>& same = of_object[(*placements)[i].object];
        if (same.empty())
            names.push_back(world_.objects[static_cast<size_t>((*placements)[i].object)].name);
        same.push_back(i);
    }
    for (const auto& [key, binding] : bindings) {
        const size_t dot = key.rfind('.');
        const std::string object = key.substr(0, dot == std::string::npos ? 0 : dot);
        const auto known = objects_.find(object);
        const auto found =
            known == objects_.end() ? of_object.end() : of_object.find(known->second);
        if (found == of_object.end()) {
            return json_.fail_with(
                error_at(binding.location, fmt::format(messages::kUniformOfNoObject, key, what),
                         messages::kUniformOfNoObjectHelp + suggest(object, names)));
        }
        if (!take_memory(value, static_cast<double>(binding_bytes(key, binding)) *
                                    static_cast<double>(found->second.size())))
            return;
        for (const size_t i : found->second)
            (*placements)[i].overrides.insert_or_assign(key.substr(dot + 1), binding);
    }
}

BuildReader::Local BuildReader::transform(const JsonValue& value, const std::string& what) {
    const JsonMember* matrix = value.find("matrix");
    const JsonValue* culprit = &value;
    Vec3d scale{1, 1, 1}, rotate, translate;
    Local out;
    bool height_given = matrix != nullptr;
    for (const char* key : {"scale", "rotate_deg", "translate_mm"}) {
        const JsonMember* p = value.find(key);
        if (p == nullptr) continue;
        if (matrix != nullptr) {
            json_.fail_at(p->line, p->column, fmt::format(messages::kMatrixAndOther, what, key),
                          messages::kOneOrTheOther);
            return out;
        }
        const std::string name = fmt::format("`{}` of {}", key, what);
        if (p->key == "scale") {
            culprit = &p->value;
            scale = one_or_three(p->value, name, 0 - kLargestScale, kLargestScale, &json_);
            continue;
        }
        const bool flat =
            p->key == "translate_mm" && p->value.is(Kind::kArray) && p->value.items.size() == 2;
        std::vector<double> n = json_.numbers(p->value, name, flat ? 2 : 3, kFarthest_mm);
        n.resize(3);
        (p->key == "rotate_deg" ? rotate : translate) = Vec3d{n[0], n[1], n[2]};
        if (p->key != "translate_mm") continue;
        height_given = !flat;
        out.on_bed = flat;
    }
    if (matrix != nullptr) {
        culprit = &matrix->value;
        out.transform = this->matrix(matrix->value, "`matrix` of " + what);
        out.transform.m = written_.exact(out.transform.m);
    } else {
        out.transform = placement_transform(scale, rotate, translate);
    }
    if (const JsonMember* p = value.find("on_bed")) {
        out.on_bed = json_.boolean(p->value, fmt::format("`on_bed` of {}", what));
        if (out.on_bed && height_given && matrix == nullptr)
            json_.fail(p->value, fmt::format(messages::kHeightAndOnBed, what),
                       messages::kHeightAndOnBedHelp);
    }
    if (!json_.ok()) return out;
    if (const Result<PolarFactors> polar = polar_factors(out.transform.m); !polar)
        json_.fail(*culprit, polar.error().message, polar.error().help);
    return out;
}

/// Reads 12 numbers, or 3 rows of 4.
Affine3d BuildReader::matrix(const JsonValue& value, const std::string& what) {
    std::vector<double> n;
    if (value.is(Kind::kArray) && value.items.size() == 3) {
        for (size_t row = 0; row < 3; ++row) {
            for (double v :
                 json_.numbers(value.items[row], fmt::format("{}[{}]", what, row), 4, kFarthest_mm))
                n.push_back(v);
        }
    } else {
        n = json_.numbers(value, what + messages::kRowsOfMatrix, 12, kFarthest_mm);
    }
    return affine_of_rows(n);
}

/// Makes copies along x, then y, then z, with `spacing_mm` between their boxes, or at a distance of
/// `step_mm`.
void BuildReader::grid(const JsonValue& value, const std::string& what,
                       std::vector<Placement>* placements) {
    const std::string name = fmt::format("`grid` of {}", what);
    if (!json_.object(value, world_keys("grid"), name)) return;
    const JsonMember* spacing = value.find("spacing_mm");
    const JsonMember* step = value.find("step_mm");
    if ((spacing != nullptr) == (step != nullptr)) {
        return json_.fail(value, fmt::format(messages::kGridNeedsSpacing, name));
    }
    const JsonValue& counts = value.find("count")->value;
    const bool three = counts.is(Kind::kArray) && counts.items.size() == 3;
    const std::vector<double> n =
        json_.numbers(counts, fmt::format("`count` of {}", name), three ? 3 : 2, 1e6);
    std::array<size_t, 3> count{1, 1, 1};
    for (size_t a = 0; a < n.size() && json_.ok(); ++a) {
        count[a] = static_cast<size_t>(
            json_.integer(counts.items[a], fmt::format("`count` of {}", name), 1, kMostPlacements));
    }
    Vec3d by;
    if (step != nullptr) {
        by = one_or_three(step->value, fmt::format("`step_mm` of {}", name), 0 - kFarthest_mm,
                          kFarthest_mm, &json_);
    } else {
        by = one_or_three(spacing->value, fmt::format("`spacing_mm` of {}", name), 0, kFarthest_mm,
                          &json_) +
             (json_.ok() ? box(value, *placements).size() : Vec3d{});
    }
    if (!json_.ok()) return;
    size_t copies = 1;
    for (const size_t n : count) {
        // Factor by factor: the full product may not fit 64 bits.
        copies *= n;
        if (!room_for(value, copies * placements->size())) return;
    }
    if (!memory_for(value, *placements, copies)) return;
    std::vector<Placement> out;
    for (size_t k = 0; k < count[2]; ++k) {
        for (size_t j = 0; j < count[1]; ++j) {
            for (size_t i = 0; i < count[0]; ++i) {
                std::vector<Placement> copy = *placements;
                move({static_cast<double>(i) * by.x, static_cast<double>(j) * by.y,
                      static_cast<double>(k) * by.z},
                     &copy);
                std::move(copy.begin(), copy.end(), std::back_inserter(out));
            }
        }
    }
    *placements = std::move(out);
}

/// Makes one copy for each transform of a file, which is applied last.
void BuildReader::copies(const JsonValue& value, const std::string& what,
                         std::vector<Placement>* placements) {
    const std::filesystem::path file =
        files_.existing(value, fmt::format("the file of `transforms` of {}", what));
    if (!json_.ok()) return;
    const Result<std::vector<Affine3d>> transforms = read_transforms(file, kMostPlacements);
    if (!transforms) return json_.fail_with(transforms.error());
    if (!room_for(value, transforms->size() * placements->size()) ||
        !memory_for(value, *placements, transforms->size()))
        return;
    std::vector<Placement> out;
    for (Affine3d transform : *transforms) {
        transform.m = written_.exact(transform.m);
        for (Placement copy : *placements) {
            copy.transform = product(transform, copy.transform);
            out.push_back(std::move(copy));
        }
    }
    *placements = std::move(out);
}

}  // namespace openfab::world

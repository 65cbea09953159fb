// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/tray_worlds.h"
#include "base/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "base/affine.h"
#include "base/polar.h"
#include "base/say.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/pieces_text.h"
#include "tools/openfab/stock.h"
#include "world/placed_box.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kWorldEnd = ".fab.json";

JsonValue of_kind(JsonValue::Kind kind) {
    JsonValue out;
    out.kind = kind;
    return out;
}

JsonValue exact(double number) {
    JsonValue out = of_kind(JsonValue::Kind::kNumber);
    out.number = number + 0.0;
    return out;
}

JsonValue list_of(const std::vector<double>& numbers, bool boolean) {
    JsonValue out = of_kind(JsonValue::Kind::kArray);
    for (const double n : numbers) {
        out.items.push_back(boolean ? of_kind(JsonValue::Kind::kBool) : exact(n));
        out.items.back().boolean = n != 0;
    }
    return out;
}

JsonValue json_of(const world::Curve& curve) {
    JsonValue keys = of_kind(JsonValue::Kind::kArray);
    for (const std::vector<double>& key : curve.keys)
        keys.items.push_back(list_of(key, false));
    JsonValue out = of_kind(JsonValue::Kind::kObject);
    set_member(&out, "keys", std::move(keys));
    if (curve.interpolation) {
        set_member(&out, "interpolation",
                   tools::json_of(std::string(world::interpolation_name(*curve.interpolation))));
    }
    return out;
}

/// Returns the values of uniforms as a world has them.
JsonValue json_of(const world::UniformBindings& all) {
    JsonValue out = of_kind(JsonValue::Kind::kObject);
    for (const auto& [name, binding] : all) {
        JsonValue value;
        if (const auto* numbers = std::get_if<std::vector<double>>(&binding.value)) {
            value = list_of(*numbers, binding.boolean);
        } else if (const auto* names = std::get_if<std::vector<std::string>>(&binding.value)) {
            value = of_kind(JsonValue::Kind::kArray);
            for (const std::string& text : *names)
                value.items.push_back(tools::json_of(text));
        } else {
            set_member(&out, name, json_of(std::get<world::Curve>(binding.value)));
            continue;
        }
        set_member(&out, name,
                   value.items.size() == 1 ? JsonValue(value.items[0]) : std::move(value));
    }
    return out;
}

JsonValue json_of(const Affine3d& map) {
    JsonValue out = of_kind(JsonValue::Kind::kArray);
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            out.items.push_back(exact(map.m[row * 3 + column]));
        out.items.push_back(tools::json_of(map.t[static_cast<int>(row)]));
    }
    return out;
}

/// Returns the box of a box that is turned at right angles.
Box3d mapped(const Box3d& box, const std::array<double, 9>& turn) {
    const Affine3d map{turn, {}};
    Box3d out;
    out.add(map.apply(box.lo));
    out.add(map.apply(box.hi));
    return out;
}

/// What is put on trays: a placement, or a piece of one.
struct Thing {
    const world::Placement* placement = nullptr;
    int32_t piece = -1;
};

class TrayWriter {
  public:
    TrayWriter(const world::World& world, const world::WorldEdit& text, const TrayOptions& options)
        : world_(world), text_(text), options_(options) {}

    Result<void> run() {
        find_things();
        const std::vector<std::array<double, 9>> turns = right_angled(options_.turns);
        poses_.resize(things_.size());
        for (size_t i = 0; i < things_.size(); ++i) {
            const Affine3d& placed = things_[i].placement->transform;
            add_poses(i, turns, Affine3d{});
            // What stands aslant may fit as it is in its mesh.
            const Result<PolarFactors> polar = polar_factors(placed.m);
            if (options_.turns != Turns::kAll || !polar) continue;
            const auto& r = polar->r;
            add_poses(i, turns,
                      Affine3d{{r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}, {}});
        }
        spots_ = put_on_trays(poses_, options_.machine.size_mm, options_.gap_mm);
        if (spots_.size() < things_.size()) return misplaced();
        for (Spot& spot : spots_)
            spot.move_mm = spot.move_mm + options_.machine.low_mm;
        // In the order of the build: fablets count instances by it.
        std::stable_sort(spots_.begin(), spots_.end(),
                         [](const Spot& a, const Spot& b) { return a.thing < b.thing; });
        int32_t trays = 0;
        for (const Spot& spot : spots_)
            trays = std::max(trays, spot.tray + 1);
        for (int32_t tray = 0; tray < trays; ++tray) {
            const Result<void> made = write_tray(tray);
            if (!made) return made;
        }
        return {};
    }

  private:
    void add_poses(size_t thing, const std::vector<std::array<double, 9>>& turns,
                   const Affine3d& first) {
        for (const auto& by : turns) {
            const std::array<double, 9> turn = product(Affine3d{by, {}}, first).m;
            const Affine3d map = product(Affine3d{turn, {}}, things_[thing].placement->transform);
            const world::Placement& placed = *things_[thing].placement;
            Box3d box;
            if (placed.extent && things_[thing].piece == placed.piece) {
                box = mapped(first.m == Affine3d{}.m ? *placed.extent : *placed.own_extent, by);
            } else {
                box = turned_box(things_[thing], map.m);
            }
            if (box.empty()) box = Box3d{{}, {}};
            poses_[thing].push_back({turn, {box.lo + map.t, box.hi + map.t}});
        }
    }

    void find_things() {
        for (const world::Placement& p : world_.build) {
            const world::Object& object = world_.objects[static_cast<size_t>(p.object)];
            if (p.piece >= 0 || object.pieces == nullptr) {
                things_.push_back({&p, p.piece});
                continue;
            }
            for (size_t i = 0; i < object.pieces->regions.size(); ++i) {
                const pieces::Region& region = object.pieces->regions[i];
                if (!region.shapes_only || !region.filled.empty())
                    things_.push_back({&p, static_cast<int32_t>(i)});
            }
        }
    }

    const world::Object& object_of(const Thing& thing) const {
        return world_.objects[static_cast<size_t>(thing.placement->object)];
    }

    /// The box of a thing under a linear map; many are copies of one.
    const Box3d& turned_box(const Thing& thing, const std::array<double, 9>& m) {
        const auto [known, fresh] = boxes_.try_emplace({thing.placement->object, thing.piece, m});
        if (!fresh) return known->second;
        known->second = world::placed_box(world_, object_of(thing), thing.piece, {m, {}});
        return known->second;
    }

    std::string name_of(const Thing& thing) const {
        const world::Object& object = object_of(thing);
        if (thing.piece < 0) return fmt::format(messages::kTheObject, object.name);
        return fmt::format(messages::kPieceOfObject,
                           object.pieces->regions[static_cast<size_t>(thing.piece)].name,
                           object.name);
    }

    Error misplaced() const {
        std::vector<bool> put(things_.size());
        for (const Spot& spot : spots_)
            put[static_cast<size_t>(spot.thing)] = true;
        const auto missing =
            static_cast<size_t>(std::find(put.begin(), put.end(), false) - put.begin());
        const Vec3d size = poses_[missing][0].box.size(), &tray = options_.machine.size_mm;
        return user_error(fmt::format(messages::kDoesNotFit, name_of(things_[missing]), size.x,
                                      size.y, size.z, tray.x, tray.y, tray.z),
                          options_.misplaced);
    }

    JsonValue item_of(const Spot& spot) const {
        const Thing& thing = things_[static_cast<size_t>(spot.thing)];
        const world::Object& object = object_of(thing);
        const Pose& pose = poses_[static_cast<size_t>(spot.thing)][spot.pose];
        Affine3d map = product(Affine3d{pose.turn, {}}, thing.placement->transform);
        map.t = map.t + spot.move_mm;
        JsonValue item = of_kind(JsonValue::Kind::kObject);
        set_member(&item, "object", tools::json_of(object.name));
        if (thing.piece >= 0) {
            const auto& region = object.pieces->regions[static_cast<size_t>(thing.piece)];
            set_member(&item, "piece", tools::json_of(region.name));
        }
        if (map.m == Affine3d{}.m) {
            set_member(&item, "translate_mm", tools::json_of(map.t));
        } else {
            set_member(&item, "matrix", json_of(map));
        }
        if (!thing.placement->overrides.empty())
            set_member(&item, "uniforms", json_of(thing.placement->overrides));
        return item;
    }

    Result<void> write_tray(int32_t tray) const {
        JsonValue build = of_kind(JsonValue::Kind::kArray);
        Box3d used;
        for (const Spot& spot : spots_) {
            if (spot.tray != tray) continue;
            build.items.push_back(item_of(spot));
            const Box3d& box = poses_[static_cast<size_t>(spot.thing)][spot.pose].box;
            used.add(Box3d{box.lo + spot.move_mm, box.hi + spot.move_mm});
        }
        world::WorldEdit text = text_;
        Result<void> done = text.remove("groups");
        if (done) done = text.remove("arrange");
        if (!options_.machine.printer.empty()) {
            if (done) done = text.set("tray", "\"corner\"");
            if (done) done = text.set("printer", json_string(options_.machine.printer));
        }
        const size_t count = build.items.size();
        if (done) done = text.set("build", text_in_world(build, std::string_view("build").size()));
        if (!done) return done;
        fs::path path = options_.output;
        if (tray > 0) {
            path = path.parent_path() /
                   fmt::format("{}-{}{}", world_stem(options_.output), tray + 1, kWorldEnd);
        }
        if (const Result<void> made = write_file(path, text.text()); !made) return made;
        show(fmt::format(messages::kTrayLine, path.string(), count, count == 1 ? "" : "s",
                         used.hi.x - options_.machine.low_mm.x,
                         used.hi.y - options_.machine.low_mm.y, used.hi.z));
        return {};
    }

    const world::World& world_;
    const world::WorldEdit& text_;
    const TrayOptions& options_;
    std::vector<Thing> things_;
    std::vector<std::vector<Pose>> poses_;
    std::vector<Spot> spots_;
    std::map<std::tuple<int32_t, int32_t, std::array<double, 9>>, Box3d> boxes_;
};

}  // namespace

Result<void> check_beside(const std::string& output, const std::string& world) {
    if (!output.ends_with(kWorldEnd))
        return usage_error(fmt::format(messages::kWorldNameEnds, output, kWorldEnd));
    std::error_code ignored;
    const auto folder = [&](const std::string& file) {
        const fs::path parent = fs::path(file).parent_path();
        return fs::weakly_canonical(parent.empty() ? fs::path(".") : parent, ignored);
    };
    if (folder(output) != folder(world)) {
        return usage_error(fmt::format(messages::kWorldMustStandBeside, output, world));
    }
    if (fs::equivalent(output, world, ignored)) {
        return usage_error(fmt::format(messages::kThisIsTheWorld, output));
    }
    return {};
}

std::string world_stem(const std::string& output) {
    const std::string name = fs::path(output).filename().string();
    return name.substr(0, name.size() - kWorldEnd.size());
}

Result<void> write_tray_worlds(const world::World& world, const world::WorldEdit& text,
                               const TrayOptions& options) {
    return TrayWriter(world, text, options).run();
}

}  // namespace openfab::tools

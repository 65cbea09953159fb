// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/split.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <optional>

#include "base/affine.h"
#include "base/near_miss.h"
#include "base/polar.h"
#include "base/say.h"
#include "base/units.h"
#include "pieces/search.h"
#include "tools/openfab/pieces_text.h"
#include "tools/openfab/split_seam.h"
#include "tools/openfab/stock.h"
#include "tools/openfab/trays.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// The machine: its tray, and the profile's name if it has one.
struct Machine {
    Vec3d tray_mm;
    std::string printer;
};

Result<Machine> machine_of(const std::string& fit) {
    if (fit.find('x') != std::string::npos && fit.ends_with("mm")) {
        Machine out;
        std::string_view rest(fit.data(), fit.size() - 2);
        for (int a = 0; a < 3; ++a) {
            const size_t end = std::min(rest.find('x'), rest.size());
            const Result<double> size = parse_length_mm(std::string(rest.substr(0, end)) + "mm");
            if (!size || !(*size > 0) || (a < 2) == (end == rest.size())) {
                return usage_error(
                    fmt::format("--fit {}: not a printer, nor a size as "
                                "490x390x200mm",
                                fit));
            }
            out.tray_mm[a] = *size;
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
        return out;
    }
    const Result<world::Printer> printer = world::load_printer(fit);
    if (!printer) return printer.error();
    if (!printer->knows_build_volume()) {
        return user_error(fmt::format("--fit {}: the size of its tray is not known", fit),
                          "give a size, as 490x390x200mm");
    }
    return Machine{printer->build_volume_mm, fit};
}

Result<double> length_of(const char* option, const std::string& text) {
    const Result<double> mm = parse_length_mm(text);
    if (mm && *mm >= 0) return *mm;
    return usage_error(fmt::format("{} {}: not a length, as 6mm", option, text));
}

/// Brings a tree from lengths of the print to those of the mesh.
void to_mesh_space(const std::array<double, 9>& stretch, pieces::Tree* tree) {
    const Affine3d s{stretch, {}};
    const auto c = cofactors(s);
    const double det = determinant(s);
    const auto back = [&](const Vec3d& p) {
        return Vec3d{(c.m[0] * p.x + c.m[3] * p.y + c.m[6] * p.z) / det,
                     (c.m[1] * p.x + c.m[4] * p.y + c.m[7] * p.z) / det,
                     (c.m[2] * p.x + c.m[5] * p.y + c.m[8] * p.z) / det};
    };
    for (pieces::Cut& cut : tree->cuts) {
        const Vec3d n = s.apply_vector(cut.normal);  // symmetric
        cut.normal = n * (1 / length(n));
        cut.offset_mm /= length(n);
        for (pieces::Connector& one : cut.connectors) {
            one.at_mm = back(one.at_mm);
            one.diameter_mm /= stretch[0];
            one.length_mm /= stretch[0];
        }
        for (pieces::Number& one : cut.numbers) {
            one.at_mm = back(one.at_mm);
            one.height_mm /= stretch[0];
            one.depth_mm /= stretch[0];
        }
    }
}

class Splitter {
  public:
    Splitter(const SplitArguments& arguments, world::World world, JsonValue root, Machine machine)
        : arguments_(arguments),
          world_(std::move(world)),
          root_(std::move(root)),
          machine_(std::move(machine)) {}

    Result<void> run() {
        if (const Result<void> read = read_options(); !read) return read;
        for (size_t i = 0; i < world_.objects.size(); ++i) {
            if (const Result<void> cut = cut_object(i); !cut) return cut;
        }
        return write();
    }

  private:
    Result<void> read_options() {
        for (const auto& [option, text, to] :
             {std::tuple{"--peg", &arguments_.peg, &search_.peg_mm},
              std::tuple{"--clearance", &arguments_.clearance, &search_.clearance_mm},
              std::tuple{"--skin", &arguments_.skin, &search_.skin_mm},
              std::tuple{"--number", &arguments_.number, &search_.number_mm},
              std::tuple{"--gap", &arguments_.gap, &gap_mm_}}) {
            const Result<double> mm = length_of(option, *text);
            if (!mm) return mm.error();
            *to = *mm;
        }
        search_.tray_mm = machine_.tray_mm;
        std::vector<std::string> names, materials;
        for (const world::Object& object : world_.objects)
            names.push_back(object.name);
        for (const world::Material& material : world_.materials)
            materials.push_back(material.name);
        const auto known = [](const std::vector<std::string>& all, const std::string& name) {
            return name.empty() || std::find(all.begin(), all.end(), name) != all.end();
        };
        if (!known(names, arguments_.object)) {
            return user_error(fmt::format("--object {}: there is none; {}", arguments_.object,
                                          suggest(arguments_.object, names)));
        }
        if (!known(materials, arguments_.material)) {
            return user_error(fmt::format("--material {}: there is none; {}", arguments_.material,
                                          suggest(arguments_.material, materials)));
        }
        material_ = arguments_.material;
        if (material_.empty() && !materials.empty()) material_ = materials[0];
        return {};
    }

    /// Cuts an object by its first placement, if that does not fit the tray.
    Result<void> cut_object(size_t index) {
        const world::Object& object = world_.objects[index];
        if (!arguments_.object.empty() && object.name != arguments_.object) return {};
        const auto placed = std::find_if(
            world_.build.begin(), world_.build.end(),
            [&](const world::Placement& p) { return p.object == static_cast<int32_t>(index); });
        if (placed == world_.build.end()) return {};
        const Result<PolarFactors> polar = polar_factors(placed->transform.m);
        if (!polar) return polar.error();
        const mesh::Mesh& mesh = world_.meshes[static_cast<size_t>(object.mesh)];
        std::vector<Vec3d> positions;
        Box3d box;
        for (const Vec3d& p : mesh.positions) {
            positions.push_back(Affine3d{polar->s, {}}.apply(p));
            box.add(positions.back());
        }
        if (positions.empty()) return {};
        const Vec3d size = box.size();
        const std::string is = fmt::format("object `{}`, {:.4g} x {:.4g} x {:.4g} mm", object.name,
                                           size.x, size.y, size.z);
        if (object.pieces != nullptr) {
            show(fmt::format("{}: it has pieces, which are kept\n", is));
            return {};
        }
        if (pieces::fits(size, machine_.tray_mm)) {
            show(fmt::format("{}: it fits as it is\n", is));
            return {};
        }
        pieces::SearchOptions search = search_;
        if (pieces::uniform_scale(polar->s) == 0 && (search.peg_mm > 0 || search.number_mm > 0)) {
            note(
                fmt::format("object `{}` is not scaled alike in all directions: no dowels and "
                            "numbers",
                            object.name));
            search.peg_mm = search.number_mm = 0;
        }
        if (!arguments_.seam.empty()) {
            const auto seam = seam_of(mesh, arguments_.seam, polar->s);
            if (!seam) return seam.error();
            search.seam = *seam;
        }
        const std::clock_t start = std::clock();
        Result<pieces::Found> found = pieces::find_cuts({positions, mesh.triangles}, search);
        if (!found) return with_context(found.error(), fmt::format("object `{}`: ", object.name));
        const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        for (pieces::Cut& cut : found->tree.cuts) {
            for (pieces::Connector& c : cut.connectors)
                c.material = material_;
        }
        show(fmt::format(
            "{}: {} pieces (a grid over its box: {}), {:.1f} s, {} planes looked at, voxels of "
            "{:.3g} mm\n",
            is, found->pieces, found->least, seconds, found->looked_at, found->voxel_mm));
        show(fmt::format(
            "  the least pieces first, then the shortest seam on the surface, here {:.4g} "
            "mm2 of voxels' faces{}, no thin ends, sections that hold a dowel\n",
            found->seam_mm2,
            arguments_.seam.empty() ? "" : fmt::format(", weighted by `{}`", arguments_.seam)));
        describe(found->tree);
        if (found->without_peg > 0) {
            note(
                fmt::format("{} faces between pieces of `{}` are too small for a dowel of {:.3g} "
                            "mm; glue them, or try a smaller `--peg`",
                            found->without_peg, object.name, search.peg_mm));
        }
        to_mesh_space(polar->s, &found->tree);
        auto made = std::make_shared<world::ObjectPieces>();
        made->tree = std::move(found->tree);
        made->regions = pieces::regions(made->tree);
        world_.objects[index].pieces = made;
        cut_.push_back(index);
        return {};
    }

    /// Says why each cut is where it is.
    void describe(const pieces::Tree& tree) const {
        for (size_t i = 0; i < tree.cuts.size(); ++i) {
            const pieces::Cut& cut = tree.cuts[i];
            show(fmt::format("  cut {}: normal {:.3g} {:.3g} {:.3g} at {:.4g} mm, {} dowels\n",
                             i + 1, cut.normal.x, cut.normal.y, cut.normal.z, cut.offset_mm,
                             cut.connectors.size()));
        }
    }

    /// Returns the values of uniforms as a world has them.
    JsonValue bindings(const world::UniformBindings& all) const {
        JsonValue out;
        out.kind = JsonValue::Kind::kObject;
        for (const auto& [name, binding] : all) {
            JsonValue value;
            value.kind = JsonValue::Kind::kArray;
            if (const auto* numbers = std::get_if<std::vector<double>>(&binding.value)) {
                for (const double n : *numbers) {
                    JsonValue one;
                    one.kind = binding.boolean ? JsonValue::Kind::kBool : JsonValue::Kind::kNumber;
                    one.number = n;
                    one.boolean = n != 0;
                    value.items.push_back(one);
                }
            } else if (const auto* names = std::get_if<std::vector<std::string>>(&binding.value)) {
                for (const std::string& text : *names)
                    value.items.push_back(json_of(text));
            } else {
                note(fmt::format("the curve `{}` of a placement is left out: give it to the object",
                                 name));
                continue;
            }
            set_member(&out, name,
                       value.items.size() == 1 ? JsonValue(value.items[0]) : std::move(value));
        }
        return out;
    }

    /// What is put on trays: a placement, or a piece of one.
    struct Thing {
        const world::Placement* placement = nullptr;
        int32_t piece = -1;
    };

    std::vector<Thing> things() const {
        std::vector<Thing> out;
        for (const world::Placement& p : world_.build) {
            const world::Object& object = world_.objects[static_cast<size_t>(p.object)];
            if (p.piece >= 0 || object.pieces == nullptr) {
                out.push_back({&p, p.piece});
                continue;
            }
            for (size_t i = 0; i < object.pieces->regions.size(); ++i) {
                const pieces::Region& region = object.pieces->regions[i];
                if (!region.shapes_only || !region.filled.empty())
                    out.push_back({&p, static_cast<int32_t>(i)});
            }
        }
        return out;
    }

    Box3d box_of(const Thing& thing, const Affine3d& map) const {
        const world::Object& object = world_.objects[static_cast<size_t>(thing.placement->object)];
        const mesh::Mesh& mesh = world_.meshes[static_cast<size_t>(object.mesh)];
        if (thing.piece >= 0) {
            return pieces::piece_box({mesh.positions, mesh.triangles},
                                     object.pieces->regions[static_cast<size_t>(thing.piece)], map);
        }
        Box3d box;
        for (const Vec3d& p : mesh.positions)
            box.add(map.apply(p));
        return box;
    }

    std::string name_of(const Thing& thing) const {
        const world::Object& object = world_.objects[static_cast<size_t>(thing.placement->object)];
        if (thing.piece < 0) return fmt::format("object `{}`", object.name);
        return fmt::format("piece `{}` of `{}`",
                           object.pieces->regions[static_cast<size_t>(thing.piece)].name,
                           object.name);
    }

    Result<void> write() {
        const std::vector<Thing> all = things();
        const std::vector<std::array<double, 9>> turns = right_angled();
        std::vector<std::vector<Pose>> poses(all.size());
        for (size_t i = 0; i < all.size(); ++i) {
            for (const auto& turn : turns) {
                const Affine3d map = product(Affine3d{turn, {}}, all[i].placement->transform);
                poses[i].push_back({turn, box_of(all[i], map)});
            }
        }
        const std::vector<Spot> spots = put_on_trays(poses, machine_.tray_mm, gap_mm_);
        if (spots.size() < all.size()) {
            std::vector<bool> put(all.size());
            for (const Spot& spot : spots)
                put[static_cast<size_t>(spot.thing)] = true;
            const auto missing =
                static_cast<size_t>(std::find(put.begin(), put.end(), false) - put.begin());
            const Vec3d size = poses[missing][0].box.size();
            return user_error(
                fmt::format("{} still does not fit: it is {:.4g} x {:.4g} x {:.4g} mm, and the "
                            "tray {:.4g} x {:.4g} x {:.4g} mm",
                            name_of(all[missing]), size.x, size.y, size.z, machine_.tray_mm.x,
                            machine_.tray_mm.y, machine_.tray_mm.z),
                "cut it once more in its `pieces`, or take its `pieces` out, so that they are "
                "found anew; turn a part whose long side is slanted");
        }
        int32_t trays = 0;
        for (const Spot& spot : spots)
            trays = std::max(trays, spot.tray + 1);
        if (const Result<void> made = write_cuts(); !made) return made;
        for (int32_t tray = 0; tray < trays; ++tray) {
            const Result<void> made = write_tray(all, poses, spots, tray);
            if (!made) return made;
        }
        return {};
    }

    std::string stem() const {
        const std::string name = fs::path(arguments_.output).filename().string();
        constexpr std::string_view kEnd = ".fab.json";
        return name.substr(0, name.size() - kEnd.size());
    }

    Result<void> write_cuts() {
        JsonMember* objects = nullptr;
        for (JsonMember& m : root_.members) {
            if (m.key == "objects") objects = &m;
        }
        for (const size_t index : cut_) {
            const world::Object& object = world_.objects[index];
            const std::string file =
                fmt::format("{}.{}cuts.json", stem(), cut_.size() > 1 ? object.name + "." : "");
            const fs::path path = fs::path(arguments_.output).parent_path() / file;
            if (const Result<void> made = write_file(path, text_of(json_of(object.pieces->tree)));
                !made)
                return made;
            show(fmt::format("{}: the cuts of `{}`, to be edited\n", path.string(), object.name));
            for (JsonMember& m : objects->value.members) {
                if (m.key == object.name) set_member(&m.value, "pieces", json_of(file));
            }
        }
        return {};
    }

    Result<void> write_tray(const std::vector<Thing>& all,
                            const std::vector<std::vector<Pose>>& poses,
                            const std::vector<Spot>& spots, int32_t tray) {
        JsonValue build;
        build.kind = JsonValue::Kind::kArray;
        for (const Spot& spot : spots) {
            if (spot.tray != tray) continue;
            const Thing& thing = all[static_cast<size_t>(spot.thing)];
            const world::Object& object =
                world_.objects[static_cast<size_t>(thing.placement->object)];
            const Pose& pose = poses[static_cast<size_t>(spot.thing)][spot.pose];
            Affine3d map = product(Affine3d{pose.turn, {}}, thing.placement->transform);
            map.t = map.t + spot.move_mm;
            JsonValue item, matrix;
            item.kind = JsonValue::Kind::kObject;
            set_member(&item, "object", json_of(object.name));
            if (thing.piece >= 0)
                set_member(&item, "piece",
                           json_of(object.pieces->regions[static_cast<size_t>(thing.piece)].name));
            const bool plain = std::equal(map.m.begin(), map.m.end(), Affine3d{}.m.begin());
            if (plain) {
                set_member(&item, "translate_mm", json_of(map.t));
            } else {
                matrix.kind = JsonValue::Kind::kArray;
                for (size_t row = 0; row < 3; ++row) {
                    for (size_t column = 0; column < 3; ++column) {
                        JsonValue n;
                        n.kind = JsonValue::Kind::kNumber;
                        n.number = map.m[row * 3 + column] + 0.0;
                        matrix.items.push_back(n);
                    }
                    matrix.items.push_back(json_of(map.t[static_cast<int>(row)]));
                }
                set_member(&item, "matrix", std::move(matrix));
            }
            if (!thing.placement->overrides.empty())
                set_member(&item, "uniforms", bindings(thing.placement->overrides));
            build.items.push_back(std::move(item));
        }
        JsonValue root = root_;
        for (const char* key : {"groups", "arrange"})
            remove_member(&root, key);
        if (!machine_.printer.empty()) {
            set_member(&root, "printer", json_of(machine_.printer));
            set_member(&root, "tray", json_of(std::string("corner")));
        }
        const size_t count = build.items.size();
        set_member(&root, "build", std::move(build));
        fs::path path = arguments_.output;
        if (tray > 0) path = path.parent_path() / fmt::format("{}-{}.fab.json", stem(), tray + 1);
        if (const Result<void> made = write_file(path, text_of(root)); !made) return made;
        show(fmt::format("{}: a tray with {} things\n", path.string(), count));
        return {};
    }

    const SplitArguments& arguments_;
    world::World world_;
    JsonValue root_;
    Machine machine_;
    pieces::SearchOptions search_;
    double gap_mm_ = 5;
    std::string material_;
    std::vector<size_t> cut_;  ///< objects
};

}  // namespace

Result<void> run_split(const SplitArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    const Result<Machine> machine = machine_of(arguments.fit);
    if (!machine) return machine.error();
    if (!arguments.output.ends_with(".fab.json")) {
        return usage_error(
            fmt::format("-o {}: a world's name ends in .fab.json", arguments.output));
    }
    std::error_code ignored;
    const auto folder = [&](const std::string& file) {
        const fs::path parent = fs::path(file).parent_path();
        return fs::weakly_canonical(parent.empty() ? fs::path(".") : parent, ignored);
    };
    if (folder(arguments.output) != folder(arguments.world)) {
        return usage_error(
            fmt::format("-o {}: the new world must stand beside {}, since it names the same files",
                        arguments.output, arguments.world));
    }
    if (fs::equivalent(arguments.output, arguments.world, ignored)) {
        return usage_error(fmt::format(
            "-o {}: this is the world itself; give the new one another name", arguments.output));
    }
    Result<world::World> world = world::load_world(
        arguments.world, {{arguments.allow.begin(), arguments.allow.end()}, *memory});
    if (!world) return world.error();
    const Result<std::string> text = read_text_file(arguments.world, world::kLargestWorld);
    if (!text) return text.error();
    Result<JsonValue> root = parse_json(*text, arguments.world, *memory);
    if (!root) return root.error();
    return Splitter(arguments, std::move(*world), std::move(*root), *machine).run();
}

}  // namespace openfab::tools

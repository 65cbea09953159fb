// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/split.h"
#include "base/json_text.h"

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
#include "tools/openfab/extents.h"
#include "tools/openfab/machine_tray.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/pieces_text.h"
#include "tools/openfab/solid_mesh.h"
#include "tools/openfab/split_places.h"
#include "tools/openfab/split_seam.h"
#include "tools/openfab/stock.h"
#include "tools/openfab/tray_worlds.h"
#include "tools/split/search.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// The place in a mesh of one in the mesh as it is stretched.
Vec3d unstretched(const std::array<double, 9>& stretch, const Vec3d& p) {
    const Affine3d s{stretch, {}};
    const auto c = cofactors(s);
    const double det = determinant(s);
    return {(c.m[0] * p.x + c.m[3] * p.y + c.m[6] * p.z) / det,
            (c.m[1] * p.x + c.m[4] * p.y + c.m[7] * p.z) / det,
            (c.m[2] * p.x + c.m[5] * p.y + c.m[8] * p.z) / det};
}

/// Brings a tree from lengths of the print to those of the mesh.
void to_mesh_space(const std::array<double, 9>& stretch, pieces::Tree* tree) {
    const Affine3d s{stretch, {}};
    const auto back = [&](const Vec3d& p) { return unstretched(stretch, p); };
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
    Splitter(const SplitArguments& arguments, world::World world, world::WorldEdit text,
             MachineTray machine, int64_t memory)
        : arguments_(arguments),
          world_(std::move(world)),
          text_(std::move(text)),
          machine_(std::move(machine)),
          memory_(memory) {}

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
            const Result<double> mm = length_option(option, *text);
            if (!mm) return mm.error();
            *to = *mm;
        }
        search_.tray_mm = machine_.size_mm;
        std::vector<std::string> names, materials;
        for (const world::Object& object : world_.objects)
            names.push_back(object.name);
        for (const world::Material& material : world_.materials)
            materials.push_back(material.name);
        const auto known = [](const std::vector<std::string>& all, const std::string& name) {
            return name.empty() || std::find(all.begin(), all.end(), name) != all.end();
        };
        if (!known(names, arguments_.object)) {
            return user_error(fmt::format(messages::kNoSuchObject, arguments_.object,
                                          suggest(arguments_.object, names)));
        }
        if (!known(materials, arguments_.material)) {
            return user_error(fmt::format(messages::kNoSuchMaterial, arguments_.material,
                                          suggest(arguments_.material, materials)));
        }
        material_ = arguments_.material;
        if (material_.empty() && !materials.empty()) material_ = materials[0];
        return {};
    }

    /// Whether a placement's own size, that it has unturned, is another one's: cuts and trays are made for one.
    bool is_alike(const world::Placement& a, const PolarFactors& of_a,
                  const world::Placement& b) const {
        const Result<PolarFactors> of_b = polar_factors(b.transform.m);
        if (!of_b) return false;
        for (size_t i = 0; i < 9; ++i)
            if (std::abs(of_a.s[i] - of_b->s[i]) > 1e-6) return false;
        if (a.own_extent.has_value() != b.own_extent.has_value()) return false;
        constexpr double kRounding = 1e-3;
        for (int k = 0; k < 3 && a.own_extent; ++k) {
            if (std::abs(a.own_extent->lo[k] - b.own_extent->lo[k]) > kRounding ||
                std::abs(a.own_extent->hi[k] - b.own_extent->hi[k]) > kRounding)
                return false;
        }
        return true;
    }

    /// Returns the size that a placement has unturned.
    static Vec3d own_size(const mesh::Mesh& mesh, const world::Placement& p) {
        if (p.own_extent) return p.own_extent->size();
        const Result<PolarFactors> polar = polar_factors(p.transform.m);
        Box3d box;
        for (const Vec3d& at : mesh.positions)
            box.add(Affine3d{polar ? polar->s : p.transform.m, {}}.apply(at));
        return box.empty() ? Vec3d{} : box.size();
    }

    /// Cuts an object that does not fit the tray by its placements, which must be of one size.
    Result<void> cut_object(size_t index) {
        const world::Object& object = world_.objects[index];
        if (!arguments_.object.empty() && object.name != arguments_.object) return {};
        const auto is_of_object = [&](const world::Placement& p) {
            return p.object == static_cast<int32_t>(index);
        };
        const auto placed = std::find_if(world_.build.begin(), world_.build.end(), is_of_object);
        if (placed == world_.build.end()) return {};
        const Result<PolarFactors> polar = polar_factors(placed->transform.m);
        if (!polar) return polar.error();
        const auto unlike =
            std::find_if(placed, world_.build.end(), [&](const world::Placement& p) {
                return is_of_object(p) && !is_alike(*placed, *polar, p);
            });
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
            show(fmt::format(messages::kHasPieces, is));
            return {};
        }
        const bool all_fit =
            std::all_of(placed, world_.build.end(), [&](const world::Placement& p) {
                return !is_of_object(p) || pieces::fits(own_size(mesh, p), machine_.size_mm);
            });
        if (!all_fit && unlike != world_.build.end()) {
            Error error = user_error(fmt::format(messages::kPlacementsUnlike, object.name),
                                     messages::kPlacementsUnlikeHelp);
            error.location = unlike->location;
            return error;
        }
        if (all_fit) {
            show(fmt::format(messages::kFitsAsItIs, is));
            return {};
        }
        pieces::SearchOptions search = search_;
        if (pieces::uniform_scale(polar->s) == 0 && (search.peg_mm > 0 || search.number_mm > 0)) {
            note(fmt::format(messages::kNotScaledAlike, object.name));
            search.peg_mm = search.number_mm = 0;
        }
        if (!arguments_.seam.empty()) {
            const auto seam = seam_of(mesh, arguments_.seam, polar->s);
            if (!seam) return seam.error();
            search.seam = *seam;
        }
        const Affine3d to_build{polar->r, placed->transform.t};
        if (!arguments_.look.empty()) {
            const Result<AtPoint> look = seam_by_colours(arguments_.look, to_build, memory_);
            if (!look) return look.error();
            search.seam = [painted = search.seam, look = *look](const Vec3d& p) {
                return look(p) * (painted ? painted(p) : 1);
            };
        }
        if (!arguments_.stress.empty()) {
            const Result<AtPoint> stress = stress_of(arguments_.stress, to_build, memory_);
            if (!stress) return stress.error();
            search.stress = *stress;
        }
        // What has no mesh has one of a box until here.
        std::vector<std::array<int32_t, 3>> triangles = mesh.triangles;
        if (placed->extent || world_.beams_of(object.mesh) != nullptr) {
            Box3d within;
            for (const Vec3d& p : positions)
                within.add(to_build.apply(p));
            if (placed->extent) {
                const Vec3d& t = placed->transform.t;
                within = {placed->extent->lo + t, placed->extent->hi + t};
            }
            Result<SolidMesh> solid = solid_mesh(
                arguments_.world, {arguments_.allow, arguments_.settings, arguments_.memory},
                object.name, within, memory_);
            if (!solid) return solid.error();
            const auto& r = polar->r;
            const Affine3d back{{r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}, {}};
            positions.clear();
            for (const Vec3d& p : solid->positions)
                positions.push_back(back.apply(p - placed->transform.t));
            triangles = std::move(solid->triangles);
            // Mirrored back, they look inwards.
            if (dot(Vec3d{r[0], r[1], r[2]},
                    cross(Vec3d{r[3], r[4], r[5]}, Vec3d{r[6], r[7], r[8]})) < 0) {
                for (auto& t : triangles)
                    std::swap(t[1], t[2]);
            }
            // Boxes of its pieces are those of the solid, too.
            mesh::Mesh own;
            for (const Vec3d& p : positions)
                own.positions.push_back(unstretched(polar->s, p));
            own.triangles = triangles;
            world_.objects[index].mesh = static_cast<int32_t>(world_.meshes.size());
            world_.meshes.push_back(std::move(own));
        }
        const std::clock_t start = std::clock();
        Result<pieces::Found> found = pieces::find_cuts({positions, triangles}, search);
        if (!found)
            return with_context(found.error(), fmt::format(messages::kInObject, object.name));
        const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        for (pieces::Cut& cut : found->tree.cuts) {
            for (pieces::Connector& c : cut.connectors)
                c.material = material_;
        }
        show(fmt::format(
            "{}: {} pieces (its box: {}), {:.1f} s, {} planes looked at, voxels of "
            "{:.3g} mm\n",
            is, found->pieces, found->least, seconds, found->looked_at, found->voxel_mm));
        show(fmt::format(messages::kSplitCriteria, likings(), found->seam_mm2,
                         arguments_.stress.empty()
                             ? ""
                             : fmt::format(messages::kLittleOfMaterial, arguments_.stress)));
        describe(found->tree);
        if (found->without_peg > 0) {
            note(fmt::format(messages::kFacesTooSmallForDowel, found->without_peg, object.name,
                             search.peg_mm));
        }
        for (const pieces::Sliver& sliver : found->slivers) {
            const Vec3d at = to_build.apply(sliver.at);
            note(fmt::format(messages::kCutLeavesSliver, sliver.cut + 1, sliver.thickness_mm,
                             object.name, at.x, at.y, at.z));
        }
        to_mesh_space(polar->s, &found->tree);
        auto made = std::make_shared<world::ObjectPieces>();
        made->tree = std::move(found->tree);
        made->regions = pieces::regions(made->tree);
        world_.objects[index].pieces = made;
        cut_.push_back(index);
        return {};
    }

    std::string likings() const {
        std::string out;
        if (!arguments_.look.empty())
            out += fmt::format(messages::kSeamWhereChanges, arguments_.look);
        if (!arguments_.seam.empty()) out += fmt::format(messages::kSeamAsPainted, arguments_.seam);
        return out;
    }

    /// Says why each cut is where it is.
    void describe(const pieces::Tree& tree) const {
        for (size_t i = 0; i < tree.cuts.size(); ++i) {
            const pieces::Cut& cut = tree.cuts[i];
            show(fmt::format("  cut {}: normal {:.3g} {:.3g} {:.3g} at {:.4g} mm, {} dowel{}\n",
                             i + 1, cut.normal.x, cut.normal.y, cut.normal.z, cut.offset_mm,
                             cut.connectors.size(), cut.connectors.size() == 1 ? "" : "s"));
        }
    }

    Result<void> write() {
        TrayOptions options;
        options.machine = machine_;
        options.gap_mm = gap_mm_;
        options.output = arguments_.output;
        options.misplaced = messages::kCutOnceMore;
        if (const Result<void> made = write_cuts(); !made) return made;
        if (const Result<void> made = write_exploded(); !made) return made;
        return write_tray_worlds(world_, text_, options);
    }

    Result<void> write_cuts() {
        for (const size_t index : cut_) {
            const world::Object& object = world_.objects[index];
            const std::string file = fmt::format("{}.{}cuts.json", world_stem(arguments_.output),
                                                 cut_.size() > 1 ? object.name + "." : "");
            const fs::path path = fs::path(arguments_.output).parent_path() / file;
            if (const Result<void> made = write_file(path, text_of(json_of(object.pieces->tree)));
                !made)
                return made;
            show(fmt::format(messages::kCutsToEdit, path.string(), object.name));
            if (const Result<void> set =
                    text_.set_of_object(object.name, "pieces", json_string(file));
                !set)
                return set;
        }
        return {};
    }

    /// Lets placements of what was cut stand for all its pieces, moved apart.
    JsonValue exploded(JsonValue placements) const {
        constexpr double kGap = 0.12;  // of the tray's longest side
        const Vec3d& tray = machine_.size_mm;
        // A dowel hangs between its holes.
        double least = 0;
        for (const size_t index : cut_) {
            for (const pieces::Cut& cut : world_.objects[index].pieces->tree.cuts) {
                for (const pieces::Connector& one : cut.connectors)
                    least = std::max(least, 1.2 * one.length_mm);
            }
        }
        const double gap_mm =
            std::round(10 * std::max({least, kGap * tray.x, kGap * tray.y, kGap * tray.z})) / 10;
        for (JsonValue& item : placements.items) {
            const JsonMember* object = item.find("object");
            const bool is_cut = object != nullptr && item.find("piece") == nullptr &&
                                std::any_of(cut_.begin(), cut_.end(), [&](size_t index) {
                                    return world_.objects[index].name == object->value.text;
                                });
            if (!is_cut) continue;
            set_member(&item, "piece", json_of(std::string("all")));
            set_member(&item, "explode_mm", json_of(gap_mm));
        }
        return placements;
    }

    /// Writes a world to look at: the parts as they were placed, with their pieces apart.
    Result<void> write_exploded() const {
        if (cut_.empty()) return {};
        world::WorldEdit text = text_;
        // It is larger than the machine.
        Result<void> done = text.remove("tray");
        if (done) done = text.set("printer", "\"generic\"");
        for (const JsonMember& m : text_.tree().members) {
            if (!done) break;
            if (m.key == "build")
                done = text.set(m.key, text_in_world(exploded(m.value), m.key.size()));
            if (m.key != "groups") continue;
            for (const JsonMember& group : m.value.members) {
                if (done)
                    done =
                        text.set_entry("groups", group.key,
                                       text_in_world(exploded(group.value), group.key.size(), 8));
            }
        }
        if (!done) return done;
        const fs::path path =
            fs::path(arguments_.output).parent_path() /
            fmt::format("exploded-{}", fs::path(arguments_.output).filename().string());
        if (const Result<void> made = write_file(path, text.text()); !made) return made;
        show(fmt::format(messages::kPiecesApart, path.string()));
        return {};
    }

    const SplitArguments& arguments_;
    world::World world_;
    world::WorldEdit text_;
    MachineTray machine_;
    int64_t memory_;
    pieces::SearchOptions search_;
    double gap_mm_ = 5;
    std::string material_;
    std::vector<size_t> cut_;  ///< objects
};

}  // namespace

Result<void> run_split(const SplitArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    const Result<MachineTray> machine = machine_tray(arguments.fit);
    if (!machine) return machine.error();
    if (const Result<void> beside = check_beside(arguments.output, arguments.world); !beside)
        return beside;
    Result<world::World> world =
        world::load_world(arguments.world, world::rules_of(arguments.allow, *memory));
    if (!world) return world.error();
    if (const Result<void> known = find_extents(
            arguments.world, {arguments.allow, arguments.settings, arguments.memory}, &*world);
        !known)
        return known.error();
    Result<world::WorldEdit> text = world::WorldEdit::of_file(arguments.world, *memory);
    if (!text) return text.error();
    return Splitter(arguments, std::move(*world), std::move(*text), *machine, *memory).run();
}

}  // namespace openfab::tools

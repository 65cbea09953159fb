// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/openfab/messages.h"
#include "tools/openfab/up_axis.h"

namespace openfab::tools {

namespace {

using mesh::BodyRole;

Box3d box_of(const mesh::LoadedMesh& body) {
    Box3d box;
    for (const Vec3d& p : body.mesh.positions)
        box.add(p);
    return box;
}

class Notes {
  public:
    Notes(const mesh::LoadedBodies& loaded, const std::string& file,
          std::vector<std::string>* notes)
        : loaded_(loaded), file_(file), notes_(*notes) {
        for (size_t b = 0; b < loaded.bodies.size(); ++b) {
            if (is_part(b)) box_.add(box_of(loaded.bodies[b]));
        }
    }

    void add(const Known& known) {
        if (!known.y_up && !mesh::format_says_up(file_)) say_y_up();
        if (!known.scale) say_unit();
        say_far(known.scale.value_or(1));
        say_overlaps();
        say_cuts();
    }

  private:
    bool is_part(size_t b) const { return loaded_.bodies[b].role == BodyRole::kPart; }

    void say_y_up() {
        const std::string why = loaded_.bodies.size() == 1 ? y_up_evidence(loaded_.bodies[0].mesh)
                                                           : y_up_evidence(whole());
        if (why.empty()) return;
        notes_.push_back(fmt::format(messages::kMayLieOnItsBack, file_, why));
    }

    void say_unit() {
        const Vec3d size = box_.size();
        if (!loaded_.unit_note.starts_with("assumed")) return;
        notes_.push_back(fmt::format(messages::kNoUnit, file_, size.x, size.y, size.z));
    }

    /// A fablet sees part space, which is scaled.
    void say_far(double scale) {
        if (box_.empty()) return;  // it has no meshes
        const double far =
            scale * std::max({std::abs(box_.lo.x), std::abs(box_.lo.y), std::abs(box_.lo.z),
                              std::abs(box_.hi.x), std::abs(box_.hi.y), std::abs(box_.hi.z)});
        constexpr double kSteps = 8'388'608;  // of single precision
        constexpr double kCoarse = 0.0005;
        if (far / kSteps < kCoarse) return;
        notes_.push_back(fmt::format(messages::kFarFromOrigin, file_, far / 1000, far / kSteps));
    }

    void say_overlaps() {
        constexpr size_t kMost = 5;
        std::string pairs;
        for (size_t i = 0; i < std::min(kMost, loaded_.overlaps.size()); ++i) {
            const auto [a, b] = loaded_.overlaps[i];
            pairs += fmt::format("{}`{}` and `{}`", i > 0 ? ", " : "", name(a), name(b));
        }
        if (pairs.empty()) return;
        if (loaded_.overlaps.size() > kMost)
            pairs += fmt::format(messages::kPairsMore, loaded_.overlaps.size() - kMost);
        notes_.push_back(fmt::format(messages::kShareVolume, pairs));
    }
    const std::string& name(int32_t body) const {
        return loaded_.bodies[static_cast<size_t>(body)].body;
    }

    void say_cuts() {
        std::string cutters, strangers;
        for (size_t b = 0; b < loaded_.bodies.size(); ++b) {
            if (is_part(b)) continue;
            const mesh::LoadedMesh& cutter = loaded_.bodies[b];
            cutters += fmt::format("{}`{}`", cutters.empty() ? "" : ", ", cutter.body);
            const Box3d box = box_of(cutter);
            for (size_t p = 0; p < loaded_.bodies.size(); ++p) {
                const mesh::LoadedMesh& part = loaded_.bodies[p];
                if (!is_part(p) || part.assembly == cutter.assembly || !box.overlaps(box_of(part)))
                    continue;
                strangers += fmt::format("{}`{}`", strangers.empty() ? "" : ", ", part.body);
            }
        }
        if (cutters.empty()) return;
        notes_.push_back(fmt::format(messages::kCutOthers, cutters));
        if (!strangers.empty()) {
            notes_.push_back(fmt::format(messages::kMayCutAssembly, strangers));
        }
    }

    mesh::Mesh whole() const {
        mesh::Mesh mesh;
        for (size_t b = 0; b < loaded_.bodies.size(); ++b) {
            if (!is_part(b)) continue;
            const mesh::Mesh& body = loaded_.bodies[b].mesh;
            const auto base = static_cast<int32_t>(mesh.positions.size());
            mesh.positions.insert(mesh.positions.end(), body.positions.begin(),
                                  body.positions.end());
            for (const auto& [x, y, z] : body.triangles)
                mesh.triangles.push_back({base + x, base + y, base + z});
        }
        return mesh;
    }

    const mesh::LoadedBodies& loaded_;
    const std::string& file_;
    std::vector<std::string>& notes_;
    Box3d box_;
};

}  // namespace

void add_notes(const mesh::LoadedBodies& loaded, const std::string& file, const Known& known,
               std::vector<std::string>* notes) {
    Notes(loaded, file, notes).add(known);
}

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/process.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "base/hash.h"
#include "base/near_miss.h"
#include "base/say.h"
#include "base/text.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

std::string hash_of(const std::vector<world::DeadNozzles>& dead) {
    Hasher hash;
    for (const world::DeadNozzles& each : dead) {
        hash.add_text(each.material);
        hash.add_text(each.substitute);
        for (const int32_t number : {each.head, each.passes, each.pass, each.jog})
            hash.add(number);
        hash.add(each.nozzles.size());
        for (const Vec2<int32_t>& range : each.nozzles)
            hash.add(range.x), hash.add(range.y);
    }
    return fmt::format("{:016x}", hash.value());
}

/// `black 12-14, 40 by white; …`, cut where there are many.
std::string describe(const std::vector<world::DeadNozzles>& dead) {
    if (dead.empty()) return "none dead";
    constexpr size_t kMost = 200;
    std::string text;
    for (const world::DeadNozzles& each : dead) {
        text += (text.empty() ? "" : "; ") + each.material;
        for (size_t i = 0; i < each.nozzles.size() && text.size() < kMost; ++i) {
            const Vec2<int32_t>& range = each.nozzles[i];
            text += fmt::format("{} {}", i == 0 ? "" : ",", range.x);
            if (range.y > range.x) text += fmt::format("-{}", range.y);
        }
        text += " by " + each.substitute;
        if (text.size() >= kMost) return text + " …";
    }
    return text;
}

/// Those of a profile, until a file that is named has others.
class NozzleFile : public process::NozzleSource {
  public:
    NozzleFile(std::vector<world::DeadNozzles> dead, std::filesystem::path file,
               std::vector<pipeline::SliceMaterial> materials, const Vec3d& own_pitch_mm)
        : dead_(std::move(dead)),
          file_(std::move(file)),
          materials_(std::move(materials)),
          own_pitch_mm_(own_pitch_mm) {
        names_.emplace_back();
        for (const pipeline::SliceMaterial& material : materials_)
            names_.push_back(material.name);
        note_time();
    }

    Result<void> begin(const Vec3d& origin_mm, const Vec3d& pitch_mm, const Vec3i& size,
                       int32_t materials) override {
        Vec3d own = own_pitch_mm_;
        for (int axis = 0; axis < 3; ++axis)
            own[axis] = own[axis] > 0 ? own[axis] : pitch_mm[axis];  // 0: not known
        rows_ = process::MachineRows::of(origin_mm, pitch_mm, own);
        size_ = size;
        model_materials_ = materials;
        changes_.clear();
        const auto made = make(dead_);
        if (!made) return made.error();
        current_ = *made;
        return {};
    }

    std::shared_ptr<const process::Nozzles> at_slice(int32_t z) override {
        const std::lock_guard lock(mutex_);
        if (!file_.empty() && note_time()) reload(z);
        return current_ == nullptr || current_->empty() ? nullptr : current_;
    }

    std::vector<std::pair<int32_t, std::string>> changes() const override {
        const std::lock_guard lock(mutex_);
        return changes_;
    }

    /// Returns the code tables; a name without a material is left out, since profiles are for many worlds.
    Result<std::shared_ptr<const process::Nozzles>> make(
        const std::vector<world::DeadNozzles>& dead) const {
        std::vector<process::DeadRows> rows;
        for (const world::DeadNozzles& each : dead) {
            const uint8_t material = material_code(materials_, each.material);
            if (material == 0) continue;
            const uint8_t substitute = material_code(materials_, each.substitute);
            if (substitute == 0 || substitute > model_materials_) {
                return user_error(fmt::format(messages::kSubstituteIs, each.material,
                                              each.substitute,
                                              substitute == 0 ? messages::kNoMaterialOfPrint
                                                              : messages::kSubstituteIsSupport));
            }
            if (substitute == material) {
                return user_error(
                    fmt::format(messages::kDeadNozzlesTwice, each.material, each.substitute));
            }
            rows.push_back(
                {material, substitute, each.nozzles, each.head, each.passes, each.pass, each.jog});
        }
        auto made = std::make_shared<process::Nozzles>(std::move(rows), rows_);
        if (const Result<void> fine = made->check(size_, names_); !fine) return fine.error();
        return std::shared_ptr<const process::Nozzles>(std::move(made));
    }

  private:
    /// Returns whether the file is another than the last time.
    bool note_time() {
        std::error_code failed;
        const auto time = std::filesystem::last_write_time(file_, failed);
        if (failed) return false;  // between two versions, say
        const auto size = std::filesystem::file_size(file_, failed);
        const auto now = std::pair(time, failed ? 0 : size);
        return std::exchange(seen_, now) != now;
    }

    void reload(int32_t z) {
        const auto dead = world::load_dead_nozzles(file_);
        auto made =
            dead ? make(*dead) : Result<std::shared_ptr<const process::Nozzles>>(dead.error());
        if (!made) {
            warn(fmt::format(messages::kNozzlesStay, z, made.error().text()));
            return;
        }
        for (const world::DeadNozzles& each : *dead) {
            if (material_code(materials_, each.material) != 0) continue;
            warn(fmt::format(messages::kDeadNozzlesIdle, printable(each.material),
                             suggest_material(materials_, each.material)));
        }
        current_ = *made;
        changes_.emplace_back(z, describe(*dead));
    }

    const std::vector<world::DeadNozzles> dead_;
    const std::filesystem::path file_;
    const std::vector<pipeline::SliceMaterial> materials_;
    const Vec3d own_pitch_mm_;
    std::vector<std::string> names_;  ///< by code
    process::MachineRows rows_;
    Vec3i size_;
    int32_t model_materials_ = 0;
    mutable std::mutex mutex_;
    std::pair<std::filesystem::file_time_type, uintmax_t> seen_;
    std::shared_ptr<const process::Nozzles> current_;
    std::vector<std::pair<int32_t, std::string>> changes_;
};

}  // namespace

Result<void> load_process_options(const Options& options, world::Printer* printer) {
    if (!options.process_file.empty()) {
        Result<world::Process> process =
            world::load_process(options.process_file, printer->process);
        if (!process) return process.error();
        printer->process = std::move(*process);
    }
    if (options.as_built) {
        // The machine undoes both.
        printer->process.scale = {1, 1, 1};
        printer->process.field.clear();
    }
    return {};
}

void scale_build(const world::Process& process, world::World* world, pipeline::PrintInput* input) {
    const Vec3d &scale = process.scale, &about = process.about_mm;
    if (scale == Vec3d{1, 1, 1}) return;
    for (world::Placement& placement : world->build) {
        Affine3d& to_build = placement.transform;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column)
                to_build.m[static_cast<size_t>(3 * row + column)] *= scale[row];
            to_build.t[row] = about[row] + scale[row] * (to_build.t[row] - about[row]);
        }
    }
    input->process.emplace_back(
        "process scale", fmt::format("{} x {} x {} about {}, {}, {} mm", scale.x, scale.y, scale.z,
                                     about.x, about.y, about.z));
}

uint8_t material_code(const std::vector<pipeline::SliceMaterial>& materials,
                      const std::string& name) {
    for (const auto member : {&pipeline::SliceMaterial::name, &pipeline::SliceMaterial::channel}) {
        for (size_t m = 0; m < materials.size(); ++m) {
            if (materials[m].*member == name) return static_cast<uint8_t>(m + 1);
        }
    }
    return 0;
}

std::string suggest_material(const std::vector<pipeline::SliceMaterial>& materials,
                             const std::string& name) {
    std::vector<std::string> names;
    for (const pipeline::SliceMaterial& material : materials)
        names.push_back(material.name);
    return suggest(name, names);
}

void warn_of_costs(const world::Process& process, pipeline::PrintInput* input) {
    if (!process.cost) return;
    const auto warn_of = [&](const char* key, const world::ByMaterial& numbers) {
        if (numbers.others) return;
        std::string idle, without;
        for (const auto& [name, number] : numbers.named) {
            if (material_code(input->materials, name) == 0)
                idle += fmt::format("{}`{}`", idle.empty() ? "" : ", ", name);
        }
        for (const pipeline::SliceMaterial& material : input->materials) {
            if (numbers.named.contains(material.name) || numbers.named.contains(material.channel))
                continue;
            without += fmt::format("{}`{}`", without.empty() ? "" : ", ", material.name);
        }
        if (idle.empty() || without.empty()) return;
        input->warnings.push_back(fmt::format(messages::kCostIdle, key, idle, without));
    };
    warn_of("price_ml", process.cost->price_ml);
    warn_of("waste_ml_swath", process.cost->waste_ml_swath);
}

namespace {

void warn_of_rows_beyond(const world::DeadNozzles& dead, const world::Printer& printer,
                         std::vector<std::string>* warnings) {
    const bool known = printer.build_volume_mm.y > 0 && printer.pitch_mm.y > 0;
    if (dead.head > 0 || !known) return;
    const auto rows =
        static_cast<int64_t>(std::ceil(printer.build_volume_mm.y / printer.pitch_mm.y));
    const int64_t of_pass = (rows + dead.passes - 1) / dead.passes;
    for (const Vec2<int32_t>& range : dead.nozzles) {
        if (range.y < of_pass || dead.jog != 0) continue;
        warnings->push_back(fmt::format(messages::kDeadNozzlesBeyond, range.y,
                                        printable(dead.material), printer.name, rows, of_pass));
        return;
    }
}

}  // namespace

Result<std::shared_ptr<process::NozzleSource>> open_nozzles(const Options& options,
                                                            const world::Printer& printer,
                                                            pipeline::PrintInput* input) {
    std::vector<world::DeadNozzles> dead = printer.process.dead;
    if (!options.nozzles_file.empty()) {
        auto read = world::load_dead_nozzles(options.nozzles_file);
        if (!read) return read.error();
        dead = std::move(*read);
    }
    if (dead.empty() && options.nozzles_file.empty())
        return std::shared_ptr<process::NozzleSource>();
    for (const world::DeadNozzles& each : dead) {
        if (material_code(input->materials, each.material) != 0) {
            warn_of_rows_beyond(each, printer, &input->warnings);
            continue;
        }
        input->warnings.push_back(fmt::format(messages::kDeadNozzlesIdle, printable(each.material),
                                              suggest_material(input->materials, each.material)));
    }
    if (!dead.empty()) {
        input->process.emplace_back("dead nozzles", describe(dead));
        input->process.emplace_back("hash of dead nozzles", hash_of(dead));
    }
    return std::shared_ptr<process::NozzleSource>(std::make_shared<NozzleFile>(
        std::move(dead), options.nozzles_file, input->materials, printer.pitch_mm));
}

}  // namespace openfab::program

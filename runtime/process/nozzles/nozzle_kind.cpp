// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `dead` of a process and `--nozzles`, which is read again where it has changed during a print.

#include "runtime/process/nozzles/nozzle_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <utility>

#include "base/hash.h"
#include "base/say.h"
#include "base/text.h"
#include "runtime/process/nozzles/dead_nozzles.h"
#include "runtime/process/nozzles/messages.h"
#include "runtime/process/nozzles/nozzles.h"

namespace openfab::process {

namespace {

std::string hash_of(const std::vector<DeadNozzles>& dead) {
    Hasher hash;
    for (const DeadNozzles& each : dead) {
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
std::string describe(const std::vector<DeadNozzles>& dead) {
    if (dead.empty()) return "none dead";
    constexpr size_t kMost = 200;
    std::string text;
    for (const DeadNozzles& each : dead) {
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

/// Says that no material of the print is meant.
std::string idle(const DeadNozzles& dead, const std::vector<PrintMaterial>& materials) {
    return fmt::format(messages::kDeadNozzlesIdle, printable(dead.material),
                       suggest_material(materials, dead.material));
}

/// Those of a profile, until a file that is named has others.
class NozzleFile : public Effect {
  public:
    NozzleFile(std::vector<DeadNozzles> dead, std::filesystem::path file, const Print& print)
        : dead_(std::move(dead)),
          file_(std::move(file)),
          materials_(print.materials),
          mixed_materials_(print.mixed_materials),
          own_pitch_mm_(print.printer.pitch_mm) {
        names_.emplace_back();
        for (const PrintMaterial& material : materials_)
            names_.push_back(material.name);
        note_time();
    }

    Result<void> begin(const EffectGrid& grid) override {
        Vec3d own = own_pitch_mm_;
        for (int axis = 0; axis < 3; ++axis)
            own[axis] = own[axis] > 0 ? own[axis] : grid.pitch_mm[axis];  // 0: not known
        rows_ = MachineRows::of(grid.origin_mm, grid.pitch_mm, own);
        size_ = grid.size;
        changes_.clear();
        auto nozzles = make(dead_);
        if (!nozzles) return nozzles.error();
        current_ = std::move(*nozzles);
        return {};
    }

    bool changes_voxels() const override { return true; }
    std::shared_ptr<const SliceEffect> at_slice(int32_t z) override {
        const std::lock_guard lock(mutex_);
        if (!file_.empty() && note_time()) reload(z);
        return current_ == nullptr || current_->empty() ? nullptr : current_;
    }

    std::vector<EffectChange> changes() const override {
        const std::lock_guard lock(mutex_);
        return changes_;
    }

    /// Returns the code tables; a name without a material is left out, since profiles are for many worlds.
    Result<std::shared_ptr<const Nozzles>> make(const std::vector<DeadNozzles>& dead) const {
        std::vector<DeadRows> rows;
        for (const DeadNozzles& each : dead) {
            const uint8_t material = material_code(materials_, each.material);
            if (material == 0) continue;
            const uint8_t substitute = material_code(materials_, each.substitute);
            if (substitute == 0 || substitute > mixed_materials_) {
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
        auto nozzles = std::make_shared<Nozzles>(std::move(rows), rows_);
        if (const Result<void> fine = nozzles->check(size_, names_); !fine) return fine.error();
        return std::shared_ptr<const Nozzles>(std::move(nozzles));
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
        const auto dead = load_dead_nozzles(file_);
        auto nozzles = dead ? make(*dead) : Result<std::shared_ptr<const Nozzles>>(dead.error());
        if (!nozzles) {
            warn(fmt::format(messages::kNozzlesStay, z, nozzles.error().text()));
            return;
        }
        for (const DeadNozzles& each : *dead) {
            if (material_code(materials_, each.material) != 0) continue;
            warn(idle(each, materials_));
        }
        current_ = *nozzles;
        changes_.push_back({"nozzle", "dead", z, describe(*dead)});
    }

    const std::vector<DeadNozzles> dead_;
    const std::filesystem::path file_;
    const std::vector<PrintMaterial> materials_;
    const int32_t mixed_materials_;
    const Vec3d own_pitch_mm_;
    std::vector<std::string> names_;  ///< by code
    MachineRows rows_;
    Vec3i size_;
    mutable std::mutex mutex_;
    std::pair<std::filesystem::file_time_type, uintmax_t> seen_;
    std::shared_ptr<const Nozzles> current_;
    std::vector<EffectChange> changes_;
};

void warn_of_rows_beyond(const DeadNozzles& dead, const world::Printer& printer,
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

class DescribedNozzles : public Described {
  public:
    explicit DescribedNozzles(std::vector<DeadNozzles> dead) : dead_(std::move(dead)) {}

    Result<std::unique_ptr<Effect>> open(const Print& print, const std::string& asked,
                                         const Told& told) const override {
        std::vector<DeadNozzles> dead = dead_;
        if (!asked.empty()) {
            auto read = load_dead_nozzles(asked);
            if (!read) return read.error();
            dead = std::move(*read);
        }
        if (dead.empty() && asked.empty()) return std::unique_ptr<Effect>();
        for (const DeadNozzles& each : dead) {
            if (material_code(print.materials, each.material) != 0)
                warn_of_rows_beyond(each, print.printer, told.warnings);
            else
                told.warnings->push_back(idle(each, print.materials));
        }
        if (!dead.empty()) {
            told.provenance->emplace_back("dead nozzles", describe(dead));
            told.provenance->emplace_back("hash of dead nozzles", hash_of(dead));
        }
        return std::unique_ptr<Effect>(std::make_unique<NozzleFile>(std::move(dead), asked, print));
    }

  private:
    std::vector<DeadNozzles> dead_;
};

}  // namespace

const Kind kNozzleKind{
    .key = "dead",
    .option = {.name = "--nozzles",
               .value = "FILE",
               .help = "dead nozzles, as JSON; a change of the file counts from the next slices on",
               .choices = {},
               .usual = {},
               .usual_as_built = {}},
    .read = [](const JsonValue* entry,
               world::JsonReader* json) -> std::unique_ptr<const Described> {
        return std::make_unique<DescribedNozzles>(entry != nullptr ? read_dead_nozzles(*entry, json)
                                                                   : std::vector<DeadNozzles>());
    },
};

}  // namespace openfab::process

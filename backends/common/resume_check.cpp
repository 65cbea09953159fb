// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/resume_check.h"

#include <fmt/format.h>

#include "backends/common/messages.h"

namespace openfab::backends {

namespace {

bool is_hash(const std::string& text) {
    return text.size() == 16 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

std::string differs(const std::string& what, const std::string& there, const std::string& here) {
    return is_hash(here) ? fmt::format(messages::kNotTheSame, what)
                         : fmt::format(messages::kIsOther, what, there, here);
}

namespace {

std::string text_of(const pipeline::SliceMaterial& m) {
    return fmt::format("{} #{:02x}{:02x}{:02x}{:02x} preview #{:02x}{:02x}{:02x}{:02x} {} g/cm3 {}",
                       m.name, m.key[0], m.key[1], m.key[2], m.key[3], m.preview[0], m.preview[1],
                       m.preview[2], m.preview[3], m.density_g_cm3, m.channel);
}

std::string material_difference(const pipeline::PrintInfo& there, const pipeline::PrintInfo& here) {
    if (there.materials.size() != here.materials.size()) {
        return differs(messages::kNumberOfMaterials, std::to_string(there.materials.size()),
                       std::to_string(here.materials.size()));
    }
    for (size_t m = 0; m < here.materials.size(); ++m) {
        const std::string a = text_of(there.materials[m]), b = text_of(here.materials[m]);
        if (a != b) return differs(fmt::format(messages::kMaterialNumber, m + 1), a, b);
    }
    return {};
}

std::string setting_difference(const pipeline::PrintInfo& there, const pipeline::PrintInfo& here) {
    if (there.provenance.empty()) {
        return messages::kNoProvenance;
    }
    for (size_t i = 0; i < here.provenance.size(); ++i) {
        const auto& [name, value] = here.provenance[i];
        if (i >= there.provenance.size() || there.provenance[i].first != name)
            return messages::kOtherSettings;
        const std::string& other = there.provenance[i].second;
        if (other != value) return differs(name, other, value);
    }
    return there.provenance.size() == here.provenance.size() ? std::string()
                                                             : messages::kOtherSettings;
}

std::string exact(const Vec3d& v) {
    return fmt::format("{} x {} x {}", v.x, v.y, v.z);
}

}  // namespace

std::string first_difference(const pipeline::PrintInfo& there, const pipeline::PrintInfo& here) {
    const auto slices = [](const pipeline::PrintInfo& i) {
        return fmt::format("{}:{}", i.slice_begin, i.slice_end);
    };
    const auto size = [](const pipeline::PrintInfo& i) {
        return fmt::format("{} x {} x {}", i.size.x, i.size.y, i.size.z);
    };
    if (there.title != here.title) return differs("world", there.title, here.title);
    if (there.printer != here.printer) return differs("printer", there.printer, here.printer);
    if (there.seed != here.seed)
        return differs("seed", std::to_string(there.seed), std::to_string(here.seed));
    if (exact(there.pitch_mm) != exact(here.pitch_mm))
        return differs(messages::kPitchInMm, exact(there.pitch_mm), exact(here.pitch_mm));
    // Before sizes: another mesh often has another size, but the mesh is the cause.
    if (std::string found = setting_difference(there, here); !found.empty()) return found;
    if (std::string found = material_difference(there, here); !found.empty()) return found;
    if (there.size != here.size) return differs(messages::kSizeInVoxels, size(there), size(here));
    if (exact(there.origin_mm) != exact(here.origin_mm))
        return differs(messages::kOriginInMm, exact(there.origin_mm), exact(here.origin_mm));
    if (slices(there) != slices(here))
        return differs(messages::kRangeOfSlices, slices(there), slices(here));
    if (there.bits != here.bits) return messages::kOtherBits;
    return {};
}

Error resume_refused(const std::string& output, const std::string& why) {
    return user_error(fmt::format(messages::kResumeRefused, output, why));
}

}  // namespace openfab::backends

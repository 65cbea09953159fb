// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_extensions.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {
namespace {

/// Extensions that are read, at least as far as a file needs that requires them.
constexpr std::string_view kExtensions[] = {
    "/material/",          "/production/",  "/trianglesets/", "/slice/",    "/securecontent/",
    "/booleanoperations/", "/beamlattice/", "/volumetric/",   "/implicit/", "/displacement/"};

/// Elements without attributes of interest, whose children count.
constexpr std::string_view kWithout[] = {"resources", "build",      "mesh",     "vertices",
                                         "triangles", "components", "metadata", "metadatagroup",
                                         "settings",  "setting"};

/// Elements that say nothing of what is printed, or of which objects that use them tell.
constexpr std::string_view kSilent[] = {"trianglesets", "slicestack"};

}  // namespace

void ThreemfTold::add(const std::string& what, const std::string& place, const std::string& remedy,
                      LeftOutKind kind) {
    for (LeftOut& known : list_) {
        if (known.what != what) continue;
        ++known.count;
        return;
    }
    // Names from the file may make each one different.
    constexpr size_t kMost = 100;
    if (list_.size() < kMost) list_.push_back({what, place, remedy, 1, kind});
}

Complaint check_threemf_extensions(const XmlAttributes& model) {
    // They are listed by their prefixes.
    const char* required = model.find("requiredextensions");
    const std::vector<std::string_view> prefixes =
        threemf_words(required != nullptr ? required : "");
    // Each is searched for among all attributes.
    constexpr size_t kMostExtensions = 64;
    if (prefixes.size() > kMostExtensions)
        return fmt::format(messages::kTooManyExtensions, prefixes.size(), kMostExtensions);
    for (const std::string_view prefix : prefixes) {
        const char* address = model.find_exact(fmt::format("xmlns:{}", prefix));
        const std::string_view known = address != nullptr ? address : "";
        const bool fine = std::any_of(
            std::begin(kExtensions), std::end(kExtensions),
            [&](std::string_view one) { return known.find(one) != std::string_view::npos; });
        if (!fine)
            return {fmt::format(messages::kRequiresThreemfExtension,
                                known.empty() ? prefix : known.substr(0, 120)),
                    messages::kRequiresThreemfExtensionHelp};
    }
    return {};
}

bool is_left_out_of_threemf(std::string_view element, const std::string& place, ThreemfTold* told) {
    const auto any = [&](const auto& list) {
        return std::find(std::begin(list), std::end(list), element) != std::end(list);
    };
    if (any(kWithout)) return false;
    if (any(kSilent)) return true;
    if (element == "volumedata") {
        told->add(messages::kVolumetricDataInsideMeshes, place,
                  messages::kVolumetricDataInsideMeshesHelp);
        return true;
    }
    if (element.ends_with("displayproperties")) {
        told->add(messages::kGlossOfMaterials, place, messages::kGlossOfMaterialsHelp);
    } else {
        told->add(fmt::format("elements `{}`", element.substr(0, 40)), place,
                  messages::kOtherExtension);
    }
    return true;
}

}  // namespace openfab::mesh

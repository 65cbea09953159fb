// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_build.h"

#include <fmt/format.h>

#include <utility>

#include "base/affine.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {

namespace {

/// Components may repeat objects, so that the file's size does not bound these.
constexpr int64_t kMostPlacements = 100'000;
constexpr size_t kMostDepth = 32;

}  // namespace

std::string ThreemfPlaced::place() const {
    return name.empty() ? fmt::format("object {}", id) : fmt::format("object `{}`", name);
}

Error ThreemfBuild::error(const std::string& what, const std::string& help) const {
    return user_error(fmt::format("{}: {}", file_, what), help);
}

Result<const ThreemfModel*> ThreemfBuild::root() {
    if (!package_) {
        Result<ThreemfPackage> package = read_threemf_package(zip_, file_, memory_bytes_);
        if (!package) return package.error();
        package_ = std::move(*package);
    }
    return part("", package_->model);
}

Result<void> ThreemfBuild::each(const std::function<Result<void>(const ThreemfPlaced&)>& visit) {
    const Result<const ThreemfModel*> model = root();
    if (!model) return model.error();
    visit_ = &visit;
    placements_ = 0;
    for (const ThreemfPlacement& item : (*model)->build) {
        if (!item.printable) {
            told_.add(messages::kItemsSwitchedOff, fmt::format("object {}", item.object),
                      messages::kSwitchThemOn);
            continue;
        }
        const Result<void> placed =
            place(**model, zip_.resolve("", package_->model), item, {}, 0, "");
        if (!placed) return placed;
    }
    return {};
}

Result<const ThreemfModel*> ThreemfBuild::part(const std::string& from, const std::string& name) {
    const std::string path = zip_.resolve(from, name);
    const std::string key = ZipFile::key(path);
    if (const auto it = parts_.find(key); it != parts_.end()) return &it->second;
    const Result<std::string> text =
        package_->read(zip_, zip_.has(path) ? path : name, file_, memory_bytes_);
    if (!text) return text.error();
    // The text lives as long as it is parsed. Meshes tell of themselves where they are read.
    const auto length = static_cast<int64_t>(text->size());
    memory_bytes_ -= length;
    ThreemfTold of_meshes;
    Result<ThreemfModel> model =
        parse_threemf_model(*text, fmt::format("{}: {}", file_, name), &memory_bytes_, &of_meshes);
    memory_bytes_ += length;
    if (!model) return model.error();
    return &parts_.emplace(key, std::move(*model)).first->second;
}

Result<void> ThreemfBuild::place(const ThreemfModel& from, const std::string& path,
                                 const ThreemfPlacement& placement, const Affine3d& at,
                                 size_t depth, const std::string& holder) {
    if (depth > kMostDepth) return error(fmt::format(messages::kNestedTooDeep, kMostDepth));
    if (++placements_ > kMostPlacements)
        return error(fmt::format(messages::kTooManyObjects, kMostPlacements));
    const ThreemfModel* in = &from;
    if (!placement.path.empty()) {
        const Result<const ThreemfModel*> other = part(path, placement.path);
        if (!other) return other.error();
        in = *other;
    }
    const auto it = in->objects.find(placement.object);
    if (it == in->objects.end())
        return error(fmt::format(messages::kNoSuchObject, placement.object));
    const ThreemfObject& object = it->second;
    const ThreemfPlaced placed{in, placement.object, &object, product(at, placement.transform),
                               object.name.empty() ? holder : object.name};
    if (Result<void> done = (*visit_)(placed); !done) return done;
    const std::string next = placement.path.empty() ? path : zip_.resolve(path, placement.path);
    for (const ThreemfPlacement& component : object.components) {
        Result<void> done = place(*in, next, component, placed.map, depth + 1, placed.name);
        if (!done) return done;
    }
    return {};
}

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/pyramid.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "base/input_file.h"
#include "texture/messages.h"
#include "texture/pyramid_file.h"

namespace openfab::texture {

namespace {

std::vector<std::string> read_notes(const std::filesystem::path& pyramid) {
    constexpr int64_t kMost = 1 << 16;
    const Result<InputFile> file = InputFile::open(notes_file(pyramid));
    if (!file) return {};
    const Result<std::string> text = file->read_all(kMost);
    std::vector<std::string> notes;
    for (size_t at = 0; text && at < text->size();) {
        const size_t end = std::min(text->find('\n', at), text->size());
        notes.push_back(text->substr(at, end - at));
        at = end + 1;
    }
    return notes;
}

}  // namespace

std::filesystem::path notes_file(const std::filesystem::path& pyramid) {
    return std::filesystem::path(pyramid).replace_extension(".notes");
}

Result<std::shared_ptr<const Pyramid>> Pyramid::open(const std::filesystem::path& file,
                                                     WrapModes wrap, int32_t filter) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) {
        return with_context(opened.error(),
                            fmt::format(messages::kCannotReadBecause, file.string()));
    }
    if (opened->bytes() == 0)
        return user_error(fmt::format(messages::kPyramidEmpty, file.string()));
    const auto bytes = static_cast<size_t>(opened->bytes());
    void* mapping = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, opened->descriptor(), 0);
    if (mapping == MAP_FAILED) {
        return outside_error(fmt::format(messages::kCannotRead, file.string(),
                                         std::generic_category().message(errno)));
    }
    std::shared_ptr<Pyramid> pyramid(new Pyramid);
    pyramid->mapping_ = mapping;
    pyramid->mapping_bytes_ = bytes;
    Result<PyramidView> view = parse_pyramid_file(mapping, bytes);
    if (!view) return with_context(view.error(), file.string() + " ");
    // Read instead of mapped, since mapped pages would count as memory of the print.
    if (Result<void> whole = check_pyramid_file(*opened); !whole)
        return with_context(whole.error(), file.string() + " ");
    pyramid->notes_ = read_notes(file);
    pyramid->info_ = pyramid_info(view->layout, wrap, filter);
    pyramid->texels_ = {view->texels, static_cast<size_t>(view->layout.texel_floats)};
    pyramid->minmax_ = {view->minmax, static_cast<size_t>(view->layout.minmax_floats)};
    return std::shared_ptr<const Pyramid>(std::move(pyramid));
}

std::shared_ptr<const Pyramid> Pyramid::from_texels(int32_t width, int32_t height, int32_t channels,
                                                    std::span<const float> level0, WrapModes wrap,
                                                    int32_t filter) {
    const Result<PyramidLayout> layout = pyramid_layout(width, height, channels);
    return layout ? fill(*layout, level0, wrap, filter) : nullptr;
}

std::shared_ptr<const Pyramid> Pyramid::from_volume(const Vec3i& size, int32_t channels,
                                                    const VolumeDomain& domain,
                                                    std::span<const float> level0, WrapModes wrap,
                                                    int32_t filter) {
    const Result<PyramidLayout> layout = volume_layout(size, channels, domain);
    return layout ? fill(*layout, level0, wrap, filter) : nullptr;
}

std::shared_ptr<const Pyramid> Pyramid::fill(const PyramidLayout& layout,
                                             std::span<const float> level0, WrapModes wrap,
                                             int32_t filter) {
    const auto texel_floats = static_cast<size_t>(layout.texel_floats);
    const size_t finest =
        layout.levels.size() > 1 ? static_cast<size_t>(layout.levels[1].texels) : texel_floats;
    if (level0.size() != finest) return nullptr;
    std::shared_ptr<Pyramid> pyramid(new Pyramid);
    pyramid->info_ = pyramid_info(layout, wrap, filter);
    pyramid->owned_.resize(texel_floats + static_cast<size_t>(layout.minmax_floats));
    float* texels = pyramid->owned_.data();
    std::copy(level0.begin(), level0.end(), texels);
    fill_pyramid(layout, texels, texels + texel_floats);
    pyramid->texels_ = {texels, texel_floats};
    pyramid->minmax_ = {texels + texel_floats, static_cast<size_t>(layout.minmax_floats)};
    return pyramid;
}

Pyramid::~Pyramid() {
    if (mapping_ != nullptr) ::munmap(mapping_, mapping_bytes_);
}

}  // namespace openfab::texture

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/icc_context.h"

#include <lcms2_plugin.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "base/text.h"

namespace openfab::tools {

namespace {

/// What lies before each block: its size, so that it can be subtracted again.
constexpr size_t kHead = alignof(std::max_align_t);

/// Of the thread that uses the library: contexts live in one function of one thread.
thread_local int64_t bytes_held = 0;
thread_local std::string last_complaint;

void* take(cmsContext, cmsUInt32Number size) {
    if (size == 0 || bytes_held + int64_t{size} > IccContext::kMostBytes) return nullptr;
    auto* const block = static_cast<char*>(std::malloc(kHead + size));
    if (block == nullptr) return nullptr;
    const size_t kept = size;
    std::memcpy(block, &kept, sizeof kept);
    bytes_held += size;
    return block + kHead;
}

void give_back(cmsContext, void* data) {
    if (data == nullptr) return;
    char* const block = static_cast<char*>(data) - kHead;
    size_t size = 0;
    std::memcpy(&size, block, sizeof size);
    bytes_held -= static_cast<int64_t>(size);
    std::free(block);
}

void* resize(cmsContext context, void* data, cmsUInt32Number size) {
    void* const moved = take(context, size);
    if (moved == nullptr || data == nullptr) return moved;
    size_t old = 0;
    std::memcpy(&old, static_cast<char*>(data) - kHead, sizeof old);
    std::memcpy(moved, data, old < size ? old : size);
    give_back(context, data);
    return moved;
}

void hear(cmsContext, cmsUInt32Number, const char* text) {
    last_complaint = printable(text);
}

cmsPluginMemHandler counted_memory() {
    cmsPluginMemHandler plugin{};
    plugin.base.Magic = cmsPluginMagicNumber;
    plugin.base.ExpectedVersion = 2000;
    plugin.base.Type = cmsPluginMemHandlerSig;
    plugin.MallocPtr = take;
    plugin.FreePtr = give_back;
    plugin.ReallocPtr = resize;
    return plugin;
}

}  // namespace

IccContext::IccContext() {
    cmsPluginMemHandler plugin = counted_memory();
    context_ = cmsCreateContext(&plugin, nullptr);
    last_complaint.clear();
    cmsSetLogErrorHandlerTHR(context_, hear);
}

IccContext::~IccContext() {
    cmsDeleteContext(context_);
}

CmsProfile IccContext::open(std::span<const uint8_t> bytes) const {
    if (bytes.size() > static_cast<size_t>(kLargestFile)) return nullptr;
    return CmsProfile(cmsOpenProfileFromMemTHR(context_, bytes.data(),
                                               static_cast<cmsUInt32Number>(bytes.size())));
}

std::string IccContext::complaint(const std::string& otherwise) const {
    return last_complaint.empty() ? otherwise : last_complaint;
}

std::string icc_description(cmsHPROFILE profile) {
    std::array<char, 256> text{};
    cmsGetProfileInfoASCII(profile, cmsInfoDescription, "en", "US", text.data(), text.size() - 1);
    return printable(text.data());
}

std::string icc_name(uint32_t signature) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8)
        out += static_cast<char>(signature >> shift & 0xff);
    while (!out.empty() && out.back() == ' ')
        out.pop_back();
    return printable(out);
}

}  // namespace openfab::tools

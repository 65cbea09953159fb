// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// ICC profiles by Little CMS, which are untrusted files: what the library allocates is counted and
// limited, and what it complains about is kept for our own message.

#include <lcms2.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"

namespace openfab::tools {

/// Closes what the library has opened.
struct CmsClose {
    void operator()(void* profile) const { cmsCloseProfile(profile); }
};
struct CmsDelete {
    void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
using CmsProfile = std::unique_ptr<void, CmsClose>;
using CmsTransform = std::unique_ptr<void, CmsDelete>;

/// A context of the library. It must outlive what is made in it.
class IccContext {
  public:
    /// The largest profile file; real ones have a few megabytes.
    static constexpr int64_t kLargestFile = 32 << 20;
    /// The most memory that the library may hold.
    static constexpr int64_t kMostBytes = 64 << 20;

    IccContext();
    ~IccContext();
    IccContext(const IccContext&) = delete;
    IccContext& operator=(const IccContext&) = delete;

    cmsContext get() const { return context_; }
    /// Opens a profile; null where it is not one.
    CmsProfile open(std::span<const uint8_t> bytes) const;
    /// Returns what the library complained about last, or `otherwise`.
    std::string complaint(const std::string& otherwise) const;

  private:
    cmsContext context_;
};

/// Returns a profile's own description as one line; "" where it has none.
std::string icc_description(cmsHPROFILE profile);

/// Names a colour space or class, four letters, for people.
std::string icc_name(uint32_t signature);

}  // namespace openfab::tools

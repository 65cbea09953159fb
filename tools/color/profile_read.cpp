// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/color/messages.h"
#include "tools/color/profile.h"
#include "tools/color/read_named.h"

namespace openfab::color {

namespace {

using tools::CmsProfile;
using tools::CmsTransform;
using tools::IccContext;

constexpr double kPercent = 100;  // inks are 0..100 in the library's floating-point formats

cmsUInt32Number number_of(Intent intent) {
    switch (intent) {
        case Intent::kPerceptual:
            return INTENT_PERCEPTUAL;
        case Intent::kRelative:
            return INTENT_RELATIVE_COLORIMETRIC;
        case Intent::kSaturation:
            return INTENT_SATURATION;
        case Intent::kAbsolute:
            return INTENT_ABSOLUTE_COLORIMETRIC;
    }
    return INTENT_PERCEPTUAL;
}

const char* kind_of(cmsProfileClassSignature kind) {
    switch (kind) {
        case cmsSigInputClass:
            return messages::kScannerProfile;
        case cmsSigDisplayClass:
            return messages::kDisplayProfile;
        case cmsSigLinkClass:
            return messages::kDeviceLink;
        case cmsSigAbstractClass:
            return messages::kAbstractProfile;
        case cmsSigColorSpaceClass:
            return messages::kColourSpaceProfile;
        case cmsSigNamedColorClass:
            return messages::kNamedColours;
        case cmsSigOutputClass:
            return messages::kPrinterProfile;
        default:
            return messages::kUnknownClass;
    }
}

// Little CMS as it computes best: nothing is resampled into a table of its own.
constexpr cmsUInt32Number kExact = cmsFLAGS_NOOPTIMIZE | cmsFLAGS_NOCACHE;

}  // namespace

Inks limited(Inks inks, double limit) {
    double sum = 0;
    for (double& ink : inks) {
        ink = std::clamp(ink, 0.0, 1.0);
        sum += ink;
    }
    if (sum > limit) {
        for (double& ink : inks)
            ink *= limit / sum;
    }
    return inks;
}

Result<PrinterProfile> PrinterProfile::read(const std::filesystem::path& file) {
    return read_named(file, IccContext::kLargestFile, [](const std::string& bytes) {
        return parse({bytes.begin(), bytes.end()});
    });
}

Result<PrinterProfile> PrinterProfile::parse(std::vector<uint8_t> bytes) {
    PrinterProfile out;
    out.bytes_ = std::move(bytes);
    out.context_ = std::make_unique<IccContext>();
    out.profile_ = out.context_->open(out.bytes_);
    const char* const kWanted = messages::kPrinterProfileWanted;
    if (out.profile_ == nullptr) {
        return user_error(
            fmt::format(messages::kNotIcc, out.context_->complaint(messages::kTooShort)), kWanted);
    }
    cmsHPROFILE const p = out.profile_.get();
    const cmsProfileClassSignature kind = cmsGetDeviceClass(p);
    if (kind != cmsSigOutputClass)
        return user_error(fmt::format(messages::kProfileIs, kind_of(kind)), kWanted);
    if (const cmsColorSpaceSignature space = cmsGetColorSpace(p); space != cmsSigCmykData) {
        return user_error(
            fmt::format(messages::kPrinterOfSpace, tools::icc_name(static_cast<uint32_t>(space))),
            kWanted);
    }
    if (!cmsIsTag(p, cmsSigAToB0Tag) || !cmsIsTag(p, cmsSigBToA0Tag)) {
        return user_error(messages::kNoTables, kWanted);
    }
    return out;
}

Result<std::vector<Inks>> PrinterProfile::to_inks(const std::vector<Rgb>& colours, Intent intent,
                                                  bool black_point) const {
    const cmsContext context = context_->get();
    const CmsProfile srgb(cmsCreate_sRGBProfileTHR(context));
    const cmsUInt32Number flags =
        kExact | (black_point ? cmsFLAGS_BLACKPOINTCOMPENSATION : cmsUInt32Number{0});
    const CmsTransform transform(cmsCreateTransformTHR(context, srgb.get(), TYPE_RGB_DBL,
                                                       profile_.get(), TYPE_CMYK_DBL,
                                                       number_of(intent), flags));
    if (transform == nullptr)
        return user_error(
            fmt::format(messages::kTablesDamaged, context_->complaint(messages::kCannotBeRead)));
    std::vector<Inks> out(colours.size());
    cmsDoTransform(transform.get(), colours.data(), out.data(),
                   static_cast<cmsUInt32Number>(colours.size()));
    for (Inks& inks : out) {
        for (double& ink : inks) {
            ink = std::clamp(ink / kPercent, 0.0, 1.0);
            if (!std::isfinite(ink)) return user_error(messages::kTablesNotFinite);
        }
    }
    return out;
}

Result<std::vector<Lab>> PrinterProfile::to_lab(const std::vector<Inks>& inks,
                                                bool absolute) const {
    const cmsContext context = context_->get();
    const CmsProfile lab(cmsCreateLab4ProfileTHR(context, nullptr));
    const CmsTransform transform(cmsCreateTransformTHR(
        context, profile_.get(), TYPE_CMYK_DBL, lab.get(), TYPE_Lab_DBL,
        absolute ? INTENT_ABSOLUTE_COLORIMETRIC : INTENT_RELATIVE_COLORIMETRIC, kExact));
    if (transform == nullptr)
        return user_error(
            fmt::format(messages::kTablesDamaged, context_->complaint(messages::kCannotBeRead)));
    std::vector<Inks> percent = inks;
    for (Inks& mixture : percent) {
        for (double& ink : mixture)
            ink *= kPercent;
    }
    std::vector<cmsCIELab> found(inks.size());
    cmsDoTransform(transform.get(), percent.data(), found.data(),
                   static_cast<cmsUInt32Number>(inks.size()));
    std::vector<Lab> out;
    out.reserve(found.size());
    for (const cmsCIELab& one : found) {
        if (!std::isfinite(one.L) || !std::isfinite(one.a) || !std::isfinite(one.b))
            return user_error(messages::kTablesNotFinite);
        out.push_back({one.L, one.a, one.b});
    }
    return out;
}

}  // namespace openfab::color

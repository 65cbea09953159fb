// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/color/messages.h"
#include "tools/color/profile.h"

namespace openfab::color {

namespace {

/// What one node of a table holds, from its inputs; 16 bits each.
using Node = std::function<void(const cmsUInt16Number* in, cmsUInt16Number* out)>;

cmsInt32Number call_node(const cmsUInt16Number in[], cmsUInt16Number out[], void* node) {
    (*static_cast<const Node*>(node))(in, out);
    return 1;
}

struct PipelineFree {
    void operator()(cmsPipeline* pipeline) const { cmsPipelineFree(pipeline); }
};
using Pipeline = std::unique_ptr<cmsPipeline, PipelineFree>;

/// The same curve for each of `channels`: v^gamma.
cmsStage* curves(cmsContext context, uint32_t channels, double gamma) {
    cmsToneCurve* const curve = cmsBuildGamma(context, gamma);
    const std::vector<cmsToneCurve*> all(channels, curve);
    cmsStage* const stage = cmsStageAllocToneCurves(context, channels, all.data());
    cmsFreeToneCurve(curve);
    return stage;
}

/// Curves that put white at the last node of a table from Lab, and zeros of a* and b* at the middle one, so
/// that greys lie on nodes: version 4 has zero at 0x8080 of 0xffff; version 2 has 100 at 0xff00, and zero at
/// the middle.
cmsStage* curves_of_lab(cmsContext context, bool version_two) {
    constexpr int kEntries = 256;  // one of them is where a curve bends
    constexpr double kWhite = 0xff00, kOne = 0xffff, kMiddle = 128;
    std::array<cmsUInt16Number, kEntries> lightness{}, other{};
    for (int i = 0; i < kEntries; ++i) {
        const double line = i / (kEntries - 1.0);
        const double below = i / (2 * kMiddle);
        const double above = 0.5 + (i - kMiddle) / (2 * (kEntries - 1 - kMiddle));
        const double l = version_two ? std::min(line * kOne / kWhite, 1.0) : line;
        const double ab = version_two ? line : i <= kMiddle ? below : above;
        const auto k = static_cast<size_t>(i);
        lightness[k] = static_cast<cmsUInt16Number>(std::lround(l * kOne));
        other[k] = static_cast<cmsUInt16Number>(std::lround(ab * kOne));
    }
    cmsToneCurve* const first = cmsBuildTabulatedToneCurve16(context, kEntries, lightness.data());
    cmsToneCurve* const rest = cmsBuildTabulatedToneCurve16(context, kEntries, other.data());
    const std::array<cmsToneCurve*, 3> all = {first, rest, rest};
    cmsStage* const stage = cmsStageAllocToneCurves(context, 3, all.data());
    cmsFreeToneCurve(first);
    cmsFreeToneCurve(rest);
    return stage;
}

/// Curves, a table, curves: what a `mAB ` or `mBA ` tag holds, or a lut16. Null where memory ran out.
Pipeline table(cmsContext context, uint32_t in, uint32_t out, int nodes, cmsStage* before,
               double gamma_out, const Node& node) {
    Pipeline pipeline(cmsPipelineAlloc(context, in, out));
    cmsStage* const grid =
        cmsStageAllocCLut16bit(context, static_cast<cmsUInt32Number>(nodes), in, out, nullptr);
    if (pipeline == nullptr || grid == nullptr) return nullptr;
    bool fine = cmsStageSampleCLut16bit(grid, call_node, const_cast<Node*>(&node), 0) != 0;
    fine = cmsPipelineInsertStage(pipeline.get(), cmsAT_END, before) && fine;
    fine = cmsPipelineInsertStage(pipeline.get(), cmsAT_END, grid) && fine;
    fine =
        cmsPipelineInsertStage(pipeline.get(), cmsAT_END, curves(context, out, gamma_out)) && fine;
    return fine ? std::move(pipeline) : nullptr;
}

/// The colour of a node of a table from Lab, behind its curves.
Lab lab_of(const cmsUInt16Number* in, bool version_two) {
    constexpr double kOne = 0xffff;
    const auto other = [&](double place) {
        constexpr double kLeast = -128, kMost = 127, kStep2 = 256;
        if (version_two) return kLeast + place * kOne / kStep2;
        return place <= 0.5 ? kLeast * (1 - 2 * place) : kMost * (2 * place - 1);
    };
    return {100 * in[0] / kOne, other(in[1] / kOne), other(in[2] / kOne)};
}

bool write_text(cmsContext context, cmsHPROFILE profile, cmsTagSignature tag,
                const std::string& text) {
    cmsMLU* const words = cmsMLUalloc(context, 1);
    const bool done = words != nullptr && cmsMLUsetASCII(words, "en", "US", text.c_str()) &&
                      cmsWriteTag(profile, tag, words);
    cmsMLUfree(words);
    return done;
}

}  // namespace

Result<std::string> make_profile(const PrinterModel& model, const ProfileOptions& options) {
    const tools::IccContext context;
    const InkGrid grid(model, options.ink_nodes);
    const Separation separation(grid, options.separation);

    const tools::CmsProfile profile(cmsCreateProfilePlaceholder(context.get()));
    if (profile == nullptr) return outside_error(messages::kNoMemoryForProfile);
    cmsHPROFILE const p = profile.get();
    const bool two = options.version_two;
    cmsSetProfileVersion(p, two ? 2.4 : 4.4);
    cmsSetDeviceClass(p, cmsSigOutputClass);
    cmsSetColorSpace(p, cmsSigCmykData);
    cmsSetPCS(p, cmsSigLabData);
    cmsSetHeaderRenderingIntent(p, INTENT_RELATIVE_COLORIMETRIC);

    // A curve of 1/2 before the table puts nodes where InkGrid has them. Behind the tables to inks, straight
    // lines keep sums of amounts between nodes, which squares would lower, so that white shows in dark
    // mixtures; but inks tint most where there is little of them.
    constexpr double kRoot = 0.5, kLinear = 1, kTint = 1.2;
    constexpr double kOne = 65535;
    const Node colour = [&](const cmsUInt16Number* in, cmsUInt16Number* out) {
        std::array<int, 4> at{};
        for (size_t i = 0; i < 4; ++i)
            at[i] = static_cast<int>(std::lround(in[i] / kOne * (options.ink_nodes - 1)));
        const Lab& lab = grid.node(at);
        const cmsCIELab rounded{lab.l, lab.a, lab.b};
        (two ? cmsFloat2LabEncodedV2 : cmsFloat2LabEncoded)(out, &rounded);
    };
    // The black of version 4's reference medium, which its readers map sources' black to (ICC.1, 6.3.3 and annex D).
    const double black = two ? 0 : 3.1373;
    const auto inks_node = [&](bool perceptual) {
        return Node([&, perceptual](const cmsUInt16Number* in, cmsUInt16Number* out) {
            const Lab lab = lab_of(in, two);
            const Inks inks = separation.find(perceptual ? separation.perceptual(lab, black) : lab);
            for (size_t i = 0; i < 4; ++i)
                out[i] =
                    static_cast<cmsUInt16Number>(std::lround(std::pow(inks[i], 1 / kTint) * kOne));
        });
    };
    const Node outside = [&](const cmsUInt16Number* in, cmsUInt16Number* out) {
        constexpr double kReached = 2;
        const Lab lab = lab_of(in, two);
        const bool reached = ciede2000(lab, grid.at(separation.find(lab))) <= kReached;
        *out = reached ? 0 : 0xffff;
    };
    constexpr int kGamutNodes = 17;
    const cmsContext c = context.get();
    const auto from_lab = [&] { return curves_of_lab(c, two); };
    const Pipeline forward =
        table(c, 4, 3, options.ink_nodes, curves(c, 4, kRoot), kLinear, colour);
    const Pipeline perceptual =
        table(c, 3, 4, options.color_nodes, from_lab(), kTint, inks_node(true));
    const Pipeline relative =
        table(c, 3, 4, options.color_nodes, from_lab(), kTint, inks_node(false));
    const Pipeline gamut =
        table(c, 3, 1, std::min(kGamutNodes, options.color_nodes), from_lab(), kLinear, outside);
    if (!forward || !perceptual || !relative || !gamut)
        return outside_error(messages::kNoMemoryForTables);

    const Xyz white = to_xyz(model.white());
    const cmsCIEXYZ white_point{white.x, white.y, white.z};
    bool done = write_text(c, p, cmsSigProfileDescriptionTag, options.description) &&
                write_text(c, p, cmsSigCopyrightTag, "No copyright, use freely") &&
                cmsWriteTag(p, cmsSigMediaWhitePointTag, &white_point) &&
                cmsWriteTag(p, cmsSigAToB0Tag, forward.get()) &&
                cmsLinkTag(p, cmsSigAToB1Tag, cmsSigAToB0Tag) &&
                cmsLinkTag(p, cmsSigAToB2Tag, cmsSigAToB0Tag) &&
                cmsWriteTag(p, cmsSigBToA0Tag, perceptual.get()) &&
                cmsWriteTag(p, cmsSigBToA1Tag, relative.get()) &&
                cmsLinkTag(p, cmsSigBToA2Tag, cmsSigBToA0Tag) &&
                cmsWriteTag(p, cmsSigGamutTag, gamut.get());
    if (done && !options.measurements.empty())
        done = write_text(c, p, cmsSigCharTargetTag, options.measurements);
    done = done && cmsMD5computeID(p);
    cmsUInt32Number bytes = 0;
    std::string out;
    done = done && cmsSaveProfileToMem(p, nullptr, &bytes);
    if (done) {
        out.resize(bytes);
        done = cmsSaveProfileToMem(p, out.data(), &bytes) != 0;
    }
    if (!done) return internal_error(context.complaint(messages::kProfileNotWritten));
    return out;
}

}  // namespace openfab::color

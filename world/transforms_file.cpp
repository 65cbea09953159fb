// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/transforms_file.h"

#include <fmt/format.h>

#include <cmath>

#include "base/check.h"
#include "base/json.h"
#include "base/plain_text.h"
#include "base/polar.h"
#include "base/scan_number.h"
#include "world/messages.h"

namespace openfab::world {
namespace {

constexpr size_t kLargestTransforms = 256'000'000;
constexpr std::string_view kBlanks = " \t\r,;";

/// Returns the numbers of a line, or the error.
std::string numbers_of(std::string_view line, std::vector<double>* out) {
    out->clear();
    line = line.substr(0, line.find('#'));
    for (;;) {
        const size_t start = line.find_first_not_of(kBlanks);
        if (start == std::string_view::npos) return {};
        line.remove_prefix(start);
        const std::string_view token = line.substr(0, line.find_first_of(kBlanks));
        line.remove_prefix(token.size());
        double value = 0;
        if (std::string wrong = scan_number(token, &value); !wrong.empty()) return wrong;
        if (!(std::fabs(value) <= kFarthest_mm))
            return fmt::format(messages::kNumberBeyond, token.substr(0, 40), kFarthest_mm);
        if (out->size() == 12) return messages::kTooManyNumbers;
        out->push_back(value);
    }
}

}  // namespace

Affine3d affine_of_rows(const std::vector<double>& n) {
    OPENFAB_CHECK_EQ(n.size(), 12u);
    return {{n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10]}, {n[3], n[7], n[11]}};
}

Result<std::vector<Affine3d>> parse_transforms(std::string_view bytes,
                                               const std::filesystem::path& file, size_t most) {
    if (const Complaint wide = not_utf8(bytes); !wide.empty())
        return wide.at({file.string(), 1, 1});
    const PlainText plain(bytes);
    std::string_view text = plain.text();
    std::vector<Affine3d> out;
    std::vector<double> n;
    for (int32_t line = 1; !text.empty(); ++line) {
        const std::string_view row = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(row.size() + 1, text.size()));
        const auto fail = [&](const std::string& what, const std::string& help = {}) {
            return error_at({file.string(), line, 1}, what, help);
        };
        if (const std::string wrong = numbers_of(row, &n); !wrong.empty()) return fail(wrong);
        if (n.empty()) continue;
        if (n.size() != 3 && n.size() != 12)
            return fail(fmt::format(messages::kTransformNumbers, n.size()),
                        messages::kTransformNumbersHelp);
        if (out.size() == most) return fail(fmt::format(messages::kTooManyTransforms, most));
        out.push_back(n.size() == 3 ? Affine3d{Affine3d{}.m, {n[0], n[1], n[2]}}
                                    : affine_of_rows(n));
        if (const Result<PolarFactors> polar = polar_factors(out.back().m); !polar)
            return fail(polar.error().message, polar.error().help);
    }
    if (out.empty()) return user_error(fmt::format(messages::kNoTransform, file.string()));
    return out;
}

Result<std::vector<Affine3d>> read_transforms(const std::filesystem::path& file, size_t most) {
    const Result<std::string> text = read_text_file(file, kLargestTransforms);
    if (!text) return text.error();
    return parse_transforms(*text, file, most);
}

}  // namespace openfab::world

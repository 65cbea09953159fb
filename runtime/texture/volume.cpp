// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/texture/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/texture/helper.h"
#include "runtime/texture/pyramid_file.h"

namespace openfab::texture {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// `%d` and `%04d` as one `%`.
std::string plain_pattern(std::string_view text) {
    std::string out;
    for (size_t i = 0; i < text.size(); ++i) {
        size_t end = i + 1;
        while (text[i] == '%' && end < text.size() && is_digit(text[end]))
            ++end;
        const bool number = text[i] == '%' && end < text.size() && text[end] == 'd';
        out += text[i];
        if (number) i = end;
    }
    return out;
}

bool matches(std::string_view pattern, std::string_view name) {
    if (pattern.empty()) return name.empty();
    const char c = pattern[0];
    const std::string_view rest = pattern.substr(1);
    if (c == '*') {
        for (size_t n = 0; n <= name.size(); ++n) {
            if (matches(rest, name.substr(n))) return true;
        }
        return false;
    }
    if (name.empty()) return false;
    if (c == '%') {
        for (size_t n = 1; n <= name.size() && is_digit(name[n - 1]); ++n) {
            if (matches(rest, name.substr(n))) return true;
        }
        return false;
    }
    if (c == '#' ? !is_digit(name[0]) : c != name[0]) return false;
    return matches(rest, name.substr(1));
}

/// Numbers by value, so that slice 10 follows slice 9.
bool comes_before(const fs::path& left, const fs::path& right) {
    const std::string a = left.filename().string(), b = right.filename().string();
    size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!is_digit(a[i]) || !is_digit(b[j])) {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i, ++j;
            continue;
        }
        const auto number = [](const std::string& s, size_t* at) {
            while (*at < s.size() && s[*at] == '0')
                ++*at;
            const size_t begin = *at;
            while (*at < s.size() && is_digit(s[*at]))
                ++*at;
            return std::string_view(s).substr(begin, *at - begin);
        };
        const std::string_view x = number(a, &i), y = number(b, &j);
        if (x.size() != y.size()) return x.size() < y.size();
        if (x != y) return x < y;
    }
    if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
    return a < b;
}

std::string three(const std::array<double, 3>& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v[0], v[1], v[2]);
}

}  // namespace

Result<std::vector<fs::path>> volume_files(const fs::path& source) {
    std::error_code trouble;
    if (fs::is_regular_file(source, trouble)) return std::vector<fs::path>{source};
    const bool folder = fs::is_directory(source, trouble);
    const fs::path place = folder ? source : source.parent_path();
    const std::string pattern = folder ? "*" : plain_pattern(source.filename().string());
    std::vector<fs::path> files;
    if (folder || pattern.find_first_of("*#%") != std::string::npos) {
        for (fs::directory_iterator it(place.empty() ? fs::path(".") : place, trouble), end;
             !trouble && it != end; it.increment(trouble)) {
            const std::string name = it->path().filename().string();
            std::error_code ignored;
            if (name[0] != '.' && it->is_regular_file(ignored) && matches(pattern, name))
                files.push_back(it->path());
        }
    }
    if (files.empty()) {
        return user_error(fmt::format("cannot read {}: {}", source.string(),
                                      folder ? "the folder is empty" : "no such file"));
    }
    std::sort(files.begin(), files.end(), comes_before);
    return files;
}

Result<uint64_t> volume_key(const fs::path& source, const VolumeOptions& options) {
    const Result<std::vector<fs::path>> files = volume_files(source);
    if (!files) return files.error();
    std::string text =
        fmt::format("volume, first row lowest|{}|{}|{}", options.origin_mm ? three(*options.origin_mm) : "",
                    options.spacing_mm ? three(*options.spacing_mm) : "", files->size());
    for (const fs::path& file : *files) {
        const Result<uint64_t> key = content_key(file, options.image);
        if (!key) return key.error();
        text += fmt::format("|{:016x}", *key);
    }
    // What kind of file it is shows in its name alone where a format has no signature.
    text += "|" + files->front().extension().string();
    return static_cast<uint64_t>(XXH3_64bits(text.data(), text.size()));
}

Result<std::shared_ptr<const Pyramid>> get_volume(const fs::path& source,
                                                  const VolumeOptions& options, int32_t wrap,
                                                  int32_t filter) {
    const Result<uint64_t> key = volume_key(source, options);
    if (!key) return key.error();
    const fs::path file = cache_file(*key);
    if (Result<std::shared_ptr<const Pyramid>> cached = Pyramid::open(file, wrap, filter))
        return cached;
    std::vector<std::string> more = {"--volume"};
    if (options.origin_mm) more.push_back("--origin=" + three(*options.origin_mm));
    if (options.spacing_mm) more.push_back("--spacing=" + three(*options.spacing_mm));
    if (Result<void> made = make_with_helper(source, options.image, file, more); !made)
        return made.error();
    return Pyramid::open(file, wrap, filter);
}

}  // namespace openfab::texture

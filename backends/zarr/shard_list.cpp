// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/shard_list.h"

#include <fmt/format.h>

#include <charconv>

#include "backends/zarr/layout.h"
#include "base/hash.h"

namespace openfab::zarr {

namespace {

constexpr std::string_view kSum = " xxh3 ";
constexpr size_t kDigits = 16;

std::string sealed(std::string line) {
    const uint64_t sum = xxh3(line);
    return fmt::format("{}{}{:016x}\n", line, kSum, sum);
}

/// Takes a sealed line off the text; none where it is damaged or cut.
std::optional<std::string_view> take_line(std::string_view* text) {
    const size_t end = text->find('\n');
    if (end == std::string_view::npos || end < kSum.size() + kDigits) return {};
    const std::string_view line = text->substr(0, end - kSum.size() - kDigits);
    if (text->substr(0, end + 1) != sealed(std::string(line))) return {};
    text->remove_prefix(end + 1);
    return line;
}

/// Reads words of a line one by one; after one that does not fit nothing does.
class Words {
  public:
    explicit Words(std::string_view line) : rest_(line) {}
    std::string_view word(char mark = ' ') {
        const size_t end = rest_.find(mark);
        const std::string_view found = rest_.substr(0, end);
        rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
        return found;
    }
    bool is(std::string_view expected) { return ok_ = ok_ && word() == expected; }
    template <typename T>
    T number(int base = 10, char mark = ' ') {
        const std::string_view digits = word(mark);
        T value{};
        const auto read =
            std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
        ok_ = ok_ && read.ec == std::errc() && read.ptr == digits.data() + digits.size();
        return ok_ ? value : T{};
    }
    bool ok() const { return ok_; }
    bool done() const { return rest_.empty(); }

  private:
    std::string_view rest_;
    bool ok_ = true;
};

bool read_slab(std::string_view line, int32_t slab, size_t levels,
               std::vector<ShardDigest>* shards) {
    Words words(line);
    if (!words.is("slab") || words.number<int32_t>() != slab) return false;
    for (size_t level = 0; level < levels; ++level) {
        const auto bytes = words.number<uint64_t>(10, ':');
        shards->push_back({bytes, words.number<uint64_t>(16)});
    }
    return words.ok() && words.done();
}

std::optional<pipeline::PrintTotals> read_end(std::string_view line) {
    Words words(line);
    pipeline::PrintTotals totals;
    totals.complete = true;
    if (!words.is("end") || !words.is("solid")) return {};
    totals.voxels_solid = words.number<int64_t>();
    if (!words.is("hash")) return {};
    totals.hash = words.number<uint64_t>(16);
    if (!words.is("tight")) return {};
    for (Vec3i* corner : {&totals.tight.lo, &totals.tight.hi})
        for (int a = 0; a < 3; ++a)
            (*corner)[a] = words.number<int32_t>();
    if (!words.is("codes")) return {};
    while (words.ok() && !words.done())
        totals.voxels_by_code.push_back(words.number<int64_t>());
    return words.ok() ? std::optional(totals) : std::nullopt;
}

}  // namespace

std::string list_name(int32_t begin, int32_t end) {
    return fmt::format("{}/{:06}-{:06}.list", kOwnFolder, begin, end);
}

std::string list_head(std::string_view identity, int32_t begin, int32_t end) {
    return sealed(fmt::format("openfab-zarr 1 of {} slices {}:{}", identity, begin, end));
}

std::string slab_line(int32_t slab, const std::vector<ShardDigest>& shards) {
    std::string line = fmt::format("slab {}", slab);
    for (const ShardDigest& shard : shards)
        line += fmt::format(" {}:{:x}", shard.bytes, shard.digest);
    return sealed(std::move(line));
}

std::string end_line(const pipeline::PrintTotals& totals) {
    const Box3i& tight = totals.tight;
    std::string line = fmt::format("end solid {} hash {:x} tight {} {} {} {} {} {} codes",
                                   totals.voxels_solid, totals.hash, tight.lo.x, tight.lo.y,
                                   tight.lo.z, tight.hi.x, tight.hi.y, tight.hi.z);
    for (const int64_t voxels : totals.voxels_by_code)
        line += fmt::format(" {}", voxels);
    return sealed(std::move(line));
}

std::optional<ShardList> parse_list(std::string_view text, std::string_view identity,
                                    size_t levels) {
    const size_t all = text.size();
    const std::optional<std::string_view> head = take_line(&text);
    if (!head) return {};
    Words words(*head);
    if (!words.is("openfab-zarr") || !words.is("1") || !words.is("of") || !words.is(identity) ||
        !words.is("slices"))
        return {};
    ShardList list;
    list.begin = words.number<int32_t>(10, ':');
    list.end = words.number<int32_t>();
    if (!words.ok() || !words.done() || list.begin < 0 || list.begin >= list.end ||
        list.begin % kSlab != 0)
        return {};
    const auto planned = static_cast<size_t>((list.end - list.begin + kSlab - 1) / kSlab);
    while (list.slabs.size() < planned) {
        list.bytes = all - text.size();
        const std::optional<std::string_view> line = take_line(&text);
        const auto slab = list.begin / kSlab + static_cast<int32_t>(list.slabs.size());
        std::vector<ShardDigest> shards;
        if (!line || !read_slab(*line, slab, levels, &shards)) return list;
        list.slabs.push_back(std::move(shards));
    }
    list.bytes = all - text.size();
    if (const std::optional<std::string_view> line = take_line(&text))
        list.totals = read_end(*line);
    return list;
}

}  // namespace openfab::zarr

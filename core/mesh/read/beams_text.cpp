// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/beams_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/near_miss.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {

namespace {

constexpr std::string_view kBlanks = " \t\r,;";
constexpr size_t kMostAttributes = 64;
constexpr double kFarthest = 1e6;

std::string_view next_word(std::string_view* line) {
    line->remove_prefix(std::min(line->find_first_not_of(kBlanks), line->size()));
    const std::string_view word = line->substr(0, line->find_first_of(kBlanks));
    line->remove_prefix(word.size());
    return word;
}

class BeamsText {
  public:
    BeamsText(const std::filesystem::path& file, int64_t memory_bytes)
        : file_(file.string()), memory_left_(memory_bytes) {}

    Result<ReadBeams> read(std::string_view text) {
        for (; !text.empty() && problem_.empty(); ++line_) {
            std::string_view row = text.substr(0, text.find('\n'));
            text.remove_prefix(std::min(row.size() + 1, text.size()));
            row = row.substr(0, row.find('#'));
            const std::string_view word = next_word(&row);
            if (word.empty()) continue;
            if (word == "node") {
                node(row);
            } else if (word == "strut") {
                strut(row);
            } else if (word == "ball") {
                ball(row);
            } else if (word == "ends") {
                ends(row);
            } else if (word == "attribute") {
                attribute(row);
            } else {
                static const std::vector<std::string> kWords = {"node", "strut", "ball", "ends",
                                                                "attribute"};
                problem_ = {fmt::format(messages::kLineBeginsWith, word.substr(0, 40)),
                            suggest(word.substr(0, 40), kWords)};
            }
            if (!problem_.empty()) break;
        }
        if (problem_.empty()) check_nodes();
        if (!problem_.empty()) return problem_.at({file_, line_, line_ > 0 ? 1 : 0});
        if (beams().beams.empty()) {
            return user_error(fmt::format(messages::kNoStrutNoBall, file_),
                              messages::kNoStrutNoBallHelp);
        }
        warn_of_unused();
        return std::move(out_);
    }

  private:
    Beams& beams() { return out_.beams; }

    bool take_memory(size_t bytes) {
        // Vectors grow by doubling, with the old one beside the new.
        memory_left_ -= 3 * static_cast<int64_t>(bytes);
        if (memory_left_ >= 0) return true;
        problem_ = {messages::kBeamsTakeTooMuch, messages::kAllowMoreMemory};
        return false;
    }

    /// Reads the numbers of a line.
    bool numbers(std::string_view row) {
        numbers_.clear();
        for (;;) {
            const std::string_view word = next_word(&row);
            if (word.empty()) return true;
            double value = 0;
            if (std::string wrong = scan_number(word, &value); !wrong.empty()) {
                problem_ = {std::move(wrong)};
                return false;
            }
            if (numbers_.size() > 4 * kMostAttributes + 4) {
                problem_ = {messages::kTooManyNumbers};
                return false;
            }
            numbers_.push_back(value);
        }
    }

    void attribute(std::string_view row) {
        const std::string name(next_word(&row)), type(next_word(&row));
        if (name.empty() || type.empty() || !next_word(&row).empty()) {
            problem_ = {messages::kAttributeNameAndType, messages::kAttributeNameAndTypeHelp};
            return;
        }
        if (!beams().nodes.empty() || !beams().beams.empty()) {
            problem_ = {fmt::format(messages::kAttributeAfterNode, name.substr(0, 40)),
                        messages::kAttributeAfterNodeHelp};
            return;
        }
        for (const BeamAttribute& other : beams().attributes) {
            if (other.name == name)
                problem_ = {fmt::format(messages::kAttributeTwice, name.substr(0, 40))};
        }
        static const std::vector<std::string> kTypes = {"float", "float2", "float3", "float4",
                                                        "int"};
        const auto found = std::ranges::find(kTypes, type);
        if (found == kTypes.end())
            problem_ = {fmt::format(messages::kAttributeOfType, type.substr(0, 40)),
                        messages::kAttributeOfTypeHelp};
        if (beams().attributes.size() == kMostAttributes)
            problem_ = {fmt::format(messages::kMoreThanAttributes, kMostAttributes)};
        if (!problem_.empty()) return;
        BeamAttribute made;
        made.name = name;
        made.is_int = found == kTypes.end() - 1;
        made.components = made.is_int ? 1 : static_cast<int32_t>(found - kTypes.begin()) + 1;
        (made.is_int ? ints_ : floats_) += made.components;
        beams().attributes.push_back(std::move(made));
    }

    /// Of the struts behind it.
    void ends(std::string_view row) {
        static const std::vector<std::string> kEnds = {"ball", "flat", "dome"};  // by BeamEnd
        const std::string first(next_word(&row)), second(next_word(&row));
        const auto end = [&](const std::string& word) {
            const auto found = std::ranges::find(kEnds, word);
            if (found == kEnds.end())
                problem_ = {fmt::format(messages::kStrutEnds, word.substr(0, 40)),
                            messages::kStrutEndsHelp};
            return static_cast<BeamEnd>(found - kEnds.begin());
        };
        const BeamEnd one = end(first), other = second.empty() ? one : end(second);
        if (!problem_.empty()) return;
        if ((one == BeamEnd::kBall) != (other == BeamEnd::kBall) || !next_word(&row).empty()) {
            problem_ = {messages::kBothStrutEnds, messages::kBothStrutEndsHelp};
            return;
        }
        ends_ = {one, other};
    }

    void node(std::string_view row) {
        if (!numbers(row)) return;
        const size_t wanted = 4 + static_cast<size_t>(floats_);
        if (numbers_.size() != wanted) {
            problem_ = {fmt::format(messages::kNodeNumbers, numbers_.size()),
                        floats_ == 0
                            ? messages::kNodeNumbersHelp
                            : fmt::format(messages::kNodeNumbersAttributesHelp, wanted, floats_)};
            return;
        }
        for (size_t a = 0; a < 3; ++a) {
            if (!(std::fabs(numbers_[a]) <= kFarthest)) {
                problem_ = {fmt::format(messages::kNodeLiesTooFar, numbers_[a], kFarthest)};
                return;
            }
        }
        if (!is_radius(numbers_[3])) return;
        if (beams().nodes.size() == static_cast<size_t>(kMostBeams)) {
            problem_ = {fmt::format(messages::kMoreThanNodes, kMostBeams)};
            return;
        }
        if (!take_memory(sizeof(Vec3d) + sizeof(float) * (1 + static_cast<size_t>(floats_)) + 1))
            return;
        beams().nodes.push_back({numbers_[0], numbers_[1], numbers_[2]});
        radii_.push_back(static_cast<float>(numbers_[3]));
        used_.push_back(0);
        size_t from = 4;
        for (BeamAttribute& to : beams().attributes) {
            for (int32_t k = 0; !to.is_int && k < to.components; ++k)
                to.values.push_back(static_cast<float>(numbers_[from++]));
        }
    }

    bool is_radius(double r) {
        if (r >= 0 && r <= kFarthest) return true;
        problem_ = {fmt::format(messages::kRadiusWrong, r), messages::kRadiusHelp};
        return false;
    }

    bool node_number(double value, int32_t* out) {
        if (value != std::floor(value) || value < 0 || value > static_cast<double>(kMostBeams)) {
            problem_ = {fmt::format(messages::kNoNumberOfNode, value),
                        messages::kNodesCountFromZero};
            return false;
        }
        *out = static_cast<int32_t>(value);
        if (*out > highest_) {
            highest_ = *out;
            highest_line_ = line_;
        }
        return true;
    }

    void strut(std::string_view row) {
        if (!numbers(row)) return;
        const auto ints = static_cast<size_t>(ints_);
        const bool own = numbers_.size() == 4 + ints;
        if (!own && numbers_.size() != 2 + ints) {
            problem_ = {fmt::format(messages::kStrutNumbers, numbers_.size()),
                        ints == 0 ? messages::kStrutNumbersHelp
                                  : fmt::format(messages::kStrutNumbersAttributesHelp, ints)};
            return;
        }
        Beam beam;
        beam.ends = ends_;
        for (size_t e = 0; e < 2; ++e) {
            if (!node_number(numbers_[e], &beam.nodes[e])) return;
            if (own && !is_radius(numbers_[2 + e])) return;
            // Those of nodes are filled in once all are known.
            beam.radii[e] = own ? static_cast<float>(numbers_[2 + e]) : -1.0f;
        }
        if (beam.nodes[0] == beam.nodes[1]) {
            problem_ = {fmt::format(messages::kStrutJoinsItself, beam.nodes[0]),
                        fmt::format(messages::kStrutJoinsItselfHelp, beam.nodes[0])};
            return;
        }
        if (own && beam.radii[0] == 0 && beam.radii[1] == 0) {
            problem_ = {messages::kAStrutWithoutRadius};
            return;
        }
        add(beam, own ? 4 : 2);
    }

    void ball(std::string_view row) {
        if (!numbers(row)) return;
        if (numbers_.size() != 1 + static_cast<size_t>(ints_)) {
            problem_ = {fmt::format(messages::kBallNumbers, numbers_.size()),
                        ints_ == 0 ? messages::kBallNumbersHelp
                                   : fmt::format(messages::kBallNumbersAttributesHelp, ints_)};
            return;
        }
        Beam beam;
        if (!node_number(numbers_[0], &beam.nodes[0])) return;
        beam.nodes[1] = beam.nodes[0];
        beam.radii = {-1, -1};
        add(beam, 1);
    }

    /// Adds a beam, whose int attributes are numbers from `from`.
    void add(const Beam& beam, size_t from) {
        if (beams().beams.size() == static_cast<size_t>(kMostBeams)) {
            problem_ = {fmt::format(messages::kMoreThanBeams, kMostBeams)};
            return;
        }
        if (!take_memory(sizeof beam + sizeof(int32_t) * (1 + static_cast<size_t>(ints_)))) return;
        beams().beams.push_back(beam);
        lines_.push_back(line_);
        for (BeamAttribute& to : beams().attributes) {
            if (!to.is_int) continue;
            const double value = numbers_[from++];
            if (value != std::floor(value) || std::fabs(value) > 2147483647.0) {
                problem_ = {
                    fmt::format(messages::kAttributeNotWholeNumber, value, to.name.substr(0, 40))};
                return;
            }
            to.ints.push_back(static_cast<int32_t>(value));
        }
    }

    /// Struts may come before their nodes.
    void check_nodes() {
        if (highest_ >= static_cast<int64_t>(beams().nodes.size())) {
            line_ = highest_line_;
            problem_ = {fmt::format(messages::kNoSuchNode, highest_, beams().nodes.size()),
                        messages::kNodesCountFromZero};
            return;
        }
        for (size_t i = 0; i < beams().beams.size(); ++i) {
            Beam& beam = beams().beams[i];
            for (size_t e = 0; e < 2; ++e) {
                const auto node = static_cast<size_t>(beam.nodes[e]);
                if (beam.radii[e] < 0) beam.radii[e] = radii_[node];
                used_[node] = 1;
            }
            if (beam.radii[0] > 0 || beam.radii[1] > 0) continue;
            line_ = lines_[i];
            problem_ = {beam.nodes[0] == beam.nodes[1]
                            ? std::string(messages::kBallWithoutRadius)
                            : std::string(messages::kAStrutWithoutRadius)};
            return;
        }
    }

    void warn_of_unused() {
        const auto unused = std::ranges::count(used_, 0);
        if (unused == 0) return;
        const auto first = std::ranges::find(used_, 0) - used_.begin();
        out_.warnings.push_back(fmt::format(messages::kNodesWithoutStrutFirst, file_, unused,
                                            used_.size(), first, first));
    }

    const std::string file_;
    int64_t memory_left_;
    ReadBeams out_;
    int32_t line_ = 1;
    Complaint problem_;
    std::vector<double> numbers_;
    std::vector<float> radii_;    ///< of nodes
    std::vector<uint8_t> used_;   ///< likewise
    std::vector<int32_t> lines_;  ///< of beams
    int32_t floats_ = 0, ints_ = 0;
    std::array<BeamEnd, 2> ends_{BeamEnd::kBall, BeamEnd::kBall};  ///< of struts that come
    int64_t highest_ = -1;
    int32_t highest_line_ = 0;
};

}  // namespace

Result<ReadBeams> parse_beams(std::string_view bytes, const std::filesystem::path& file,
                              int64_t memory_bytes) {
    if (const Complaint wide = not_utf8(bytes); !wide.empty())
        return wide.at({file.string(), 1, 1});
    const PlainText plain(bytes);
    return BeamsText(file, memory_bytes - static_cast<int64_t>(bytes.size()) - plain.copied_bytes())
        .read(plain.text());
}

}  // namespace openfab::mesh

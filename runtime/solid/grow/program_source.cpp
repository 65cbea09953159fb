// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/program_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "base/hash.h"
#include "base/talking_program.h"
#include "base/text.h"
#include "mesh/check/mesh_check.h"
#include "runtime/part/bind_shape.h"
#include "runtime/part/part_mesh.h"
#include "runtime/solid/grow/body_source.h"
#include "runtime/solid/grow/program_answer.h"
#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/solid/messages.h"

namespace openfab::solid {

namespace {

constexpr size_t kKeyWords = kKeyBytes / sizeof(uint32_t);
constexpr int32_t kMostLevels = 1000;
constexpr const char* kRootKey = "root";
/// Of one answer, in the order of which it is.
constexpr uint64_t kNumbers = uint64_t{1} << 24;
/// Hashes of answers that are kept, to be compared.
constexpr size_t kMostHashes = 1 << 20;

/// A component of a @nearest input: where it is among the attributes of a kind, or a default.
struct Reading {
    size_t at = 0;
    std::optional<uint32_t> otherwise;
};

class ProgramSource final : public BodySource {
  public:
    ProgramSource(const part::GrownGeometry& grown, const openfab_fablet& fablet,
                  const Bodies& bodies, const surface::SurfaceOptions& options)
        : BodySource(*grown.stage, bodies, options.isa),
          stage_(*grown.stage),
          table_(*grown.program),
          options_(options),
          program_(of().command, of().folder, {of().answer_ms, of().most_bytes}) {
        layout_.places = of().places;
        for (const world::ProgramRef::Attribute& attribute : of().attributes)
            (attribute.is_int ? layout_.ints : layout_.floats) += attribute.components;
        for (int32_t i = 0; i < fablet.nearest_count; ++i)
            add_reading(fablet.nearest[i]);
        for (const Vec3d& p : stage_.mesh->positions)
            box_.add(vec_cast<float>(p + stage_.mesh->center_part_mm));
    }

    BeamValues values() const override {
        return {static_cast<int32_t>(floats_.size()), static_cast<int32_t>(ints_.size())};
    }
    bool has_bodies() const override { return true; }
    void set_stop(const std::atomic<bool>* stop) const override {
        BodySource::set_stop(stop);
        stop_ = stop;
    }

    Bud root(std::vector<uint32_t>* state) const override {
        *state = state_of(kRootKey);
        Bud bud;
        bud.bound = box_;
        bud.level = -1;
        bud.children = 1;
        return bud;
    }

    Result<std::shared_ptr<const Clump>> grow(const Bud& bud,
                                              std::span<const uint32_t> state) const override {
        const std::string key = key_of(state);
        const std::string asked =
            fmt::format("grow {} {} {} {} {} {} {}", printable(key), bud.bound.lo.x, bud.bound.lo.y,
                        bud.bound.lo.z, bud.bound.hi.x, bud.bound.hi.y, bud.bound.hi.z);
        const Question question{bud, asked};
        const Result<std::string> told = ask(question);
        if (!told) return told.error();
        const Result<ProgramAnswer> answer = read_program_answer(*told, layout_);
        if (!answer)
            return placed(
                fmt::format(messages::kAskedBefore, program_.name(), asked, answer.error().message),
                answer.error().help);
        auto out = std::make_shared<Clump>();
        out->state_size = kKeyWords;
        for (size_t i = 0; i < answer->items.size(); ++i) {
            if (Result<void> fine = take(question, *answer, i, out.get()); !fine)
                return fine.error();
        }
        for (const ProgramAnswer::More& more : answer->more) {
            if (Result<void> fine = take_more(question, more, out.get()); !fine)
                return fine.error();
        }
        out->set_seed(bud, state);
        out->finish();
        // A copy takes no more memory than it needs.
        return std::make_shared<const Clump>(*out);
    }

  private:
    struct Question {
        const Bud& bud;
        const std::string& asked;
    };

    const world::ProgramRef& of() const { return *table_.program; }

    void add_reading(const openfab_varying& input) {
        const bool is_float = input.scalar == OPENFAB_FLOAT;
        std::vector<Reading>& to = is_float ? floats_ : ints_;
        size_t at = 0;
        for (const world::ProgramRef::Attribute& attribute : of().attributes) {
            if (attribute.is_int == is_float) continue;
            const auto components = static_cast<size_t>(attribute.components);
            if (attribute.name == input.name) {
                for (size_t k = 0; k < components; ++k)
                    to.push_back({at + k, {}});
                return;
            }
            at += components;
        }
        for (int32_t k = 0; k < input.components; ++k)
            to.push_back({0, input.default_bits[k]});
    }

    static std::vector<uint32_t> state_of(const std::string& key) {
        std::vector<uint32_t> state(kKeyWords, 0);
        std::memcpy(state.data(), key.data(), key.size());
        return state;
    }
    static std::string key_of(std::span<const uint32_t> state) {
        std::array<char, kKeyBytes> text;
        std::memcpy(text.data(), state.data(), text.size());
        return {text.data(), ::strnlen(text.data(), text.size())};
    }

    Error placed(const std::string& what, const std::string& help) const {
        return error_at(stage_.location, fmt::format("`{}`: {}", stage_.name, what), help);
    }
    Error error(const Question& question, int32_t line, const std::string& what,
                const std::string& help) const {
        return placed(
            fmt::format(messages::kAskedAtLine, program_.name(), question.asked, line, what), help);
    }

    /// Asks the program, and compares with what it told before.
    Result<std::string> ask(const Question& question) const {
        const std::lock_guard lock(mutex_);
        Result<std::string> told = program_.ask(question.asked, stop_);
        if (!told) {
            if (told.error().code == ErrorCode::kInterrupted) return told.error();
            Error error = placed(told.error().message, told.error().help);
            error.code = told.error().code;
            return error;
        }
        const uint64_t key = xxh3(question.asked), hash = xxh3(*told);
        if (told_.size() >= kMostHashes && !told_.contains(key)) return told;
        const auto [known, first] = told_.try_emplace(key, hash);
        if (!first && known->second != hash) {
            return placed(fmt::format(messages::kAnswersOtherwise, program_.name(), question.asked),
                          messages::kAnswersOtherwiseHelp);
        }
        return told;
    }

    /// Children's ids keep the order of lines: of beams that are as near, the first counts.
    static uint64_t id_of(const Bud& bud, size_t number) {
        return (child_id(bud.id, 0) & ~(kNumbers - 1)) + number % kNumbers;
    }

    void take_values(const ProgramAnswer& answer, size_t item, Clump* out) const {
        const auto floats = static_cast<size_t>(layout_.floats);
        const auto ints = static_cast<size_t>(layout_.ints);
        for (size_t end = 0; end < 2; ++end) {
            for (const Reading& r : floats_)
                out->floats.push_back(r.otherwise
                                          ? std::bit_cast<float>(*r.otherwise)
                                          : answer.floats[(2 * item + end) * floats + r.at]);
        }
        for (const Reading& r : ints_)
            out->ints.push_back(r.otherwise ? *r.otherwise : answer.ints[item * ints + r.at]);
    }

    Result<void> take(const Question& question, const ProgramAnswer& answer, size_t number,
                      Clump* out) const {
        const ProgramAnswer::Item& item = answer.items[number];
        const Box3f& within = question.bud.bound;
        const uint64_t id = id_of(question.bud, number);
        const int32_t level = question.bud.level + 1;
        if (item.kind == ProgramAnswer::Kind::kBeam || item.kind == ProgramAnswer::Kind::kFlat) {
            GrownBeam beam;
            beam.end = item.end;
            beam.radius = item.radius;
            beam.flat = item.kind == ProgramAnswer::Kind::kFlat;
            beam.id = id;
            beam.level = level;
            if (!holds(within, box_of(beam)))
                return outside(question, item.line, messages::kABeam, box_of(beam));
            take_values(answer, number, out);
            out->beams.push_back(beam);
            return {};
        }
        GrownBody body;
        body.axes = {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
        if (item.kind == ProgramAnswer::Kind::kPlace) {
            body.solid = standing()[static_cast<size_t>(item.which)];
            body.at = vec_cast<double>(item.end[0]);
            if (const Complaint bad = body.set_axes(item.axes); !bad.empty())
                return error(question, item.line, bad.what, bad.help);
        } else {
            Result<std::shared_ptr<const Standing>> made =
                stand(question, item.line, answer.meshes[static_cast<size_t>(item.which)]);
            if (!made) return made.error();
            body.solid = std::move(*made);
            out->own_bytes += body.solid->bytes();
        }
        if (const Box3f reached = body.reached(); !holds(within, reached))
            return outside(question, item.line,
                           item.kind == ProgramAnswer::Kind::kPlace ? messages::kWhatItPlaces
                                                                    : messages::kAMesh,
                           reached);
        take_values(answer, number, out);
        out->add_body(std::move(body), id, level, within);
        return {};
    }

    Error outside(const Question& question, int32_t line, const char* what,
                  const Box3f& box) const {
        const Box3f& within = question.bud.bound;
        return error(
            question, line,
            fmt::format(messages::kReachesOutside, what, text(box.lo), text(box.hi),
                        text(within.lo), text(within.hi)),
            question.bud.level < 0 ? messages::kEnlargeWorldBox : messages::kEnlargeMoreBox);
    }

    /// Makes a solid of a mesh in an answer.
    Result<std::shared_ptr<const Standing>> stand(const Question& question, int32_t line,
                                                  mesh::Mesh mesh) const {
        mesh::MeshSource source;
        mesh.name = fmt::format(messages::kOfLine, line);
        source.mesh = std::move(mesh);
        source.unit_mm = 1;
        if (Result<void> fine = mesh::prepare_mesh(&source); !fine)
            return error(question, line, fine.error().message, messages::kEdgesNotClosed);
        auto part = std::make_shared<part::Part>();
        part->name = stage_.name;
        part->fablet = &part::kGeometry;
        Result<std::shared_ptr<const part::PartMesh>> made =
            part::make_part_mesh(source.mesh, part::kGeometry, {1, 0, 0, 0, 1, 0, 0, 0, 1});
        if (!made) return made.error();
        part->mesh = std::move(*made);
        part->local_to_build.t = part->mesh->center_part_mm;
        Result<std::shared_ptr<Solid>> solid = kMeshKind.make(*part, options_, {});
        if (!solid) return solid.error();
        return std::make_shared<const Standing>(std::move(part), std::move(*solid), queries());
    }

    Result<void> take_more(const Question& question, const ProgramAnswer::More& more,
                           Clump* out) const {
        const Bud& from = question.bud;
        if (!holds(from.bound, more.box))
            return outside(question, more.line,
                           fmt::format(messages::kBoxOf, printable(more.key)).c_str(), more.box);
        if (from.level >= kMostLevels)
            return error(question, more.line, fmt::format(messages::kMoreTooDeep, kMostLevels),
                         messages::kMoreTooDeepHelp);
        Bud& bud = out->buds.emplace_back();
        bud.bound = more.box;
        bud.level = from.level + 1;
        const std::vector<uint32_t> state = state_of(more.key);
        bud.id = xxh3({reinterpret_cast<const uint8_t*>(state.data()), kKeyBytes},
                      child_id(from.id, static_cast<int32_t>(out->buds.size())));
        bud.children = 1;
        bud.state = out->states.size();
        out->states.insert(out->states.end(), state.begin(), state.end());
        return {};
    }

    const part::ShapeStage& stage_;
    const part::ProgramTable& table_;
    const surface::SurfaceOptions options_;
    AnswerLayout layout_;
    std::vector<Reading> floats_, ints_;
    Box3f box_;
    mutable std::atomic<const std::atomic<bool>*> stop_{nullptr};
    mutable std::mutex mutex_;
    mutable TalkingProgram program_;
    mutable std::unordered_map<uint64_t, uint64_t> told_;  ///< hashes of questions and answers
};

}  // namespace

std::unique_ptr<const ClumpSource> make_program_source(const part::GrownGeometry& of,
                                                       const openfab_fablet& fablet,
                                                       const Bodies& bodies,
                                                       const surface::SurfaceOptions& options) {
    return std::make_unique<ProgramSource>(of, fablet, bodies, options);
}

}  // namespace openfab::solid

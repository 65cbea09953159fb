// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include "backends/common/output_file.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/talking_program.h"
#include "base/text.h"
#include "base/units.h"
#include "program/messages.h"
#include "program/output_check.h"
#include "tools/openfab/check_findings.h"
#include "tools/openfab/check_voxels.h"
#include "tools/openfab/messages.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr int32_t kMostParts = 3;

class Checker {
  public:
    explicit Checker(const CheckArguments& arguments) : arguments_(arguments) {}

    Result<void> run() {
        const Result<int64_t> memory = parse_memory_option(arguments_.memory);
        if (!memory) return memory.error();
        memory_ = *memory;
        if (const Result<void> read = read_printer(); !read) return read;
        if (const Result<void> apart = check_own_outputs(); !apart) return apart;
        Result<CheckedPrint> print = is_print() ? of_print() : of_world();
        if (!print) return print.error();
        // Prints do not keep the channels that profiles name materials by.
        for (pipeline::SliceMaterial& material : print->info.materials) {
            if (material.channel.empty()) material.channel = channels_[material.name];
        }
        std::vector<std::string> notes;
        const Result<std::vector<Finding>> found =
            find_faults(*print, *limits_, &notes, [this](const char* what, int number, int count) {
                constexpr std::chrono::seconds kLong{2};
                if (std::chrono::steady_clock::now() - began_ >= kLong)
                    say(fmt::format(messages::kLooksFor, what, number, count));
            });
        if (!found) return found.error();
        for (const std::string& text : notes)
            note(text);
        tell(*print, *found);
        if (!arguments_.picture.empty()) {
            const Result<void> written =
                backends::write_whole_file(arguments_.picture, picture_of(*print, *found));
            if (!written) return written;
        }
        if (!arguments_.report.empty()) {
            const Result<void> written =
                backends::write_whole_file(arguments_.report, report(*print, *found));
            if (!written) return written;
        }
        if (found->empty()) return {};
        return user_error(fmt::format(messages::kPlacesNotAllowed, found->size(),
                                      found->size() == 1 ? " that" : "s that"),
                          arguments_.before_print() ? messages::kNothingPrintedAfterCheck : "");
    }

  private:
    bool is_print() const { return arguments_.file.ends_with(".ofr"); }

    Result<void> read_printer() {
        std::string name = arguments_.printer;
        if (!is_print()) {
            const bool is_world = arguments_.file.ends_with(".json");
            if (!is_world && !arguments_.before_print()) {
                return usage_error(
                    fmt::format(messages::kNeitherWorldNorPrint, printable(arguments_.file)));
            }
            if (is_world) {
                const Result<void> read = read_world(&name);
                if (!read) return read;
            }
        }
        if (name.empty()) name = "generic";
        Result<world::Printer> printer = world::load_printer(name);
        if (!printer) return printer.error();
        printer_ = std::move(*printer);
        if (!arguments_.process.empty()) {
            Result<world::Process> process =
                world::load_process(arguments_.process, printer_.process);
            if (!process) return process.error();
            printer_.process = std::move(*process);
        }
        limits_ = printer_.process.checks;
        return {};
    }

    /// Reads the channels of a world, and its printer's name if none is given.
    Result<void> read_world(std::string* printer) {
        const Result<world::World> world = world::load_world(
            arguments_.file, world::rules_of(arguments_.allow, memory_), world::MeshFiles::kSkip);
        if (!world) return world.error();
        if (printer->empty()) *printer = world->printer;
        for (const world::Material& material : world->materials)
            channels_[material.name] = material.channel;
        inputs_.insert(inputs_.end(), world->files.begin(), world->files.end());
        return {};
    }

    Result<void> check_own_outputs() {
        inputs_.emplace_back(arguments_.file);
        for (const std::string& file : {arguments_.process, arguments_.printer}) {
            if (!file.empty()) inputs_.emplace_back(file);
        }
        std::vector<program::NamedOutput> outputs;
        const char* picture = arguments_.before_print() ? "--check-picture" : "-o";
        if (!arguments_.picture.empty()) outputs.push_back({picture, arguments_.picture});
        if (!arguments_.report.empty()) outputs.push_back({"--report", arguments_.report});
        return program::check_outputs(outputs, inputs_);
    }

    /// Sets limits that are given by options, and usual ones where there are none, for the voxels of a machine; `usual` is
    /// what is to be said of these, or empty.
    Result<void> read_limits(const Vec3d& pitch, std::string* usual) {
        usual->clear();
        bool given = limits_.has_value();
        world::Checks limits = limits_.value_or(world::Checks());
        const auto length = [&](const char* option, const std::string& text,
                                world::ByMaterial* to) -> Result<void> {
            if (text.empty()) return {};
            const Result<double> mm = parse_length_mm(text);
            if (!mm)
                return usage_error(
                    fmt::format(program::messages::kOfOption, option, mm.error().text()));
            if (!(*mm >= 0)) return usage_error(fmt::format(messages::kNotALengthAs, option, text));
            to->others = *mm;
            given = true;
            return {};
        };
        const auto volume = [&](const char* option, const std::string& text,
                                std::optional<double>* to) -> Result<void> {
            if (text.empty()) return {};
            const std::string number =
                text.ends_with("mm3") ? text.substr(0, text.size() - 3) : text;
            double mm3 = -1;
            const auto end = std::from_chars(number.data(), number.data() + number.size(), mm3);
            if (end.ec != std::errc() || end.ptr != number.data() + number.size() || !(mm3 >= 0))
                return usage_error(fmt::format(messages::kNotAVolumeAs, option, text));
            *to = mm3;
            given = true;
            return {};
        };
        for (const Result<void>& read :
             {length("--wall", arguments_.wall, &limits.wall_mm),
              length("--gap", arguments_.gap, &limits.gap_mm),
              length("--hole", arguments_.hole, &limits.hole_mm),
              volume("--island", arguments_.island, &limits.island_mm3.others),
              volume("--trapped", arguments_.trapped, &limits.trapped_mm3)}) {
            if (!read) return read;
        }
        for (const std::string& pair : arguments_.apart) {
            const size_t comma = pair.find(',');
            if (comma == std::string::npos)
                return usage_error(fmt::format(messages::kNotTwoNames, pair));
            if (pair.substr(0, comma) == pair.substr(comma + 1))
                return usage_error(fmt::format(messages::kApartFromItself, pair));
            limits.apart.emplace_back(pair.substr(0, comma), pair.substr(comma + 1));
            given = true;
        }
        if (!given) {
            const double two = 2 * std::max({pitch.x, pitch.y, pitch.z});
            limits.wall_mm.others = limits.gap_mm.others = limits.hole_mm.others = two;
            limits.island_mm3.others = 1;
            limits.trapped_mm3 = 0;
            *usual = fmt::format(messages::kProfileWithoutChecks, two);
        }
        limits_ = std::move(limits);
        return {};
    }

    int64_t bytes_of(const Grid& grid) const {
        return check_bytes(grid.size, grid.pitch_mm, grid.parts, *limits_);
    }
    bool takes_too_much(const Grid& grid) const { return bytes_of(grid) > memory_; }
    /// As `--memory` takes them, rounded up.
    static int64_t megabytes(int64_t bytes) { return (bytes + 999'999) / 1'000'000; }
    Error takes_error(const Grid& grid, const std::string& help) const {
        return user_error(fmt::format(messages::kCheckTakes, grid.size.x, grid.size.y, grid.size.z,
                                      format_bytes(bytes_of(grid))),
                          help);
    }

    Result<CheckedPrint> of_print() {
        if (!arguments_.settings.empty())
            return usage_error(fmt::format(messages::kSetOfPrint, printable(arguments_.file)));
        const std::pair<bool, const char*> of_worlds[] = {{arguments_.draft != 0, "--draft"},
                                                          {arguments_.parts != 0, "--parts"},
                                                          {!arguments_.allow.empty(), "--allow"}};
        for (const auto& [is_given, option] : of_worlds) {
            if (is_given)
                return usage_error(
                    fmt::format(messages::kOptionOfWorlds, option, printable(arguments_.file)));
        }
        auto reader = ofr::OfrReader::open(arguments_.file, memory_);
        if (!reader) return reader.error();
        const Grid grid = grid_of((*reader)->info(), 1);
        std::string usual;
        if (const Result<void> read = read_limits(grid.pitch_mm, &usual); !read)
            return read.error();
        if (!usual.empty()) note(usual);
        if (takes_too_much(grid)) {
            return takes_error(
                grid, fmt::format(messages::kCheckTakesPrintHelp, megabytes(bytes_of(grid))));
        }
        return read_print(reader->get(), 1);
    }

    Vec3d pitch_of_world() const {
        return arguments_.before_print() ? arguments_.pitch_mm(printer_.pitch_mm)
                                         : printer_.pitch_mm * static_cast<double>(draft_);
    }

    /// Prints the world at a part of the pitch, so that walls of k voxels are told from those of k + 1; where nobody gave
    /// one, as coarse a draft of it as memory takes.
    Result<CheckedPrint> of_world() {
        draft_ = std::max(arguments_.draft, 1);
        const Vec3d own = pitch_of_world();
        if (!(std::min({own.x, own.y, own.z}) > 0)) {
            return user_error(fmt::format(messages::kPitchNotKnown, printer_.name),
                              arguments_.before_print() ? messages::kPitchNotKnownWorldHelp
                                                        : messages::kPitchNotKnownPrintHelp);
        }
        auto folder = TemporaryFolder::create();
        if (!folder) return folder.error();
        const fs::path file = (*folder)->path() / "check.ofr";
        const std::optional<world::Checks> of_profile = limits_;
        int32_t parts = 0;
        std::string usual;
        while (parts == 0) {
            limits_ = of_profile;
            if (const Result<void> read = read_limits(pitch_of_world(), &usual); !read)
                return read.error();
            const Result<int32_t> printed = print_in_parts(file);
            if (!printed) return printed.error();
            parts = *printed;
        }
        if (!usual.empty()) note(usual);
        auto reader = ofr::OfrReader::open(file.string(), memory_);
        if (!reader) return reader.error();
        if (parts < kMostParts && arguments_.parts == 0)
            note(fmt::format(messages::kPartsOfVoxel, parts, kMostParts));
        return read_print(reader->get(), parts);
    }

    /// Prints with as many parts of each voxel as memory takes, and returns how many; 0: with none, and the draft is now
    /// coarser.
    Result<int32_t> print_in_parts(const fs::path& file) {
        int32_t parts = arguments_.parts > 0 ? arguments_.parts : kMostParts;
        while (true) {
            const auto argv = print_words(file, pitch_of_world() * (1.0 / parts));
            if (!argv) return argv.error();
            const auto stopped =
                print_for_check(*argv, file, parts, memory_,
                                [&](const Grid& grid) { return !takes_too_much(grid); });
            if (!stopped) return stopped.error();
            if (!*stopped) return parts;
            int32_t fewer = parts - 1;
            while (fewer > 0 && takes_too_much(in_parts(**stopped, fewer)))
                --fewer;
            if (fewer > 0 && arguments_.parts == 0) {
                parts = fewer;
                continue;
            }
            // Of the check that takes least, where the number of parts is ours to choose.
            const Grid least = arguments_.parts > 0 ? **stopped : in_parts(**stopped, 1);
            const std::optional<int32_t> draft = draft_that_fits(**stopped);
            if (fewer > 0 || !draft || arguments_.draft > 0)
                return takes_error(least, way_out(least, fewer, draft));
            draft_ = *draft;
            const Vec3d pitch = pitch_of_world();
            note(fmt::format(messages::kCheckedCoarser, format_bytes(bytes_of(least)),
                             format_bytes(memory_), draft_, pitch.x, pitch.y, pitch.z,
                             megabytes(bytes_of(least))));
            return 0;
        }
    }
    static Grid in_parts(const Grid& grid, int32_t parts) {
        Grid out = coarser(grid, static_cast<double>(grid.parts) / parts);
        out.parts = parts;
        return out;
    }

    /// Returns a coarser draft that takes no more than the memory; nothing before a print, whose pitch is given.
    std::optional<int32_t> draft_that_fits(const Grid& grid) const {
        constexpr int32_t kCoarsest = 64;  // as the option's
        const Grid whole = in_parts(grid, arguments_.parts > 0 ? grid.parts : 1);
        for (int32_t draft = draft_ + 1; !arguments_.before_print() && draft <= kCoarsest;
             ++draft) {
            if (!takes_too_much(coarser(whole, static_cast<double>(draft) / draft_))) return draft;
        }
        return std::nullopt;
    }

    /// Says what would take no more than the memory: fewer parts, or a coarser draft.
    std::string way_out(const Grid& least, int32_t fewer_parts,
                        std::optional<int32_t> draft) const {
        const int64_t memory = megabytes(bytes_of(least));
        if (fewer_parts > 0)
            return fmt::format(messages::kCheckTakesPartsHelp, memory, fewer_parts);
        if (draft) return fmt::format(messages::kCheckTakesHelp, memory, *draft);
        return fmt::format(messages::kCheckTakesPrintHelp, memory);
    }

    /// Returns the command that prints the world.
    Result<std::vector<std::string>> print_words(const fs::path& file, const Vec3d& pitch) const {
        const Result<fs::path> programs = program_folder();
        if (!programs) return programs.error();
        std::vector<std::string> argv{(*programs / "openfab").string(),
                                      "print",
                                      arguments_.file,
                                      "-o",
                                      file.string(),
                                      "--pitch",
                                      fmt::format("{},{},{}", pitch.x, pitch.y, pitch.z),
                                      "--progress",
                                      "json",
                                      "--bleed",
                                      "off"};
        const auto option = [&](const char* name, const std::string& value) {
            if (value.empty()) return;
            argv.emplace_back(name);
            argv.push_back(value);
        };
        option("--printer", arguments_.printer);
        option("--process", arguments_.process);
        option("--threads", arguments_.threads > 0 ? std::to_string(arguments_.threads) : "");
        for (const std::string& allow : arguments_.allow)
            argv.push_back(allow_argument(allow));
        for (const std::string& one : arguments_.settings)
            argv.push_back("--set=" + one);
        argv.insert(argv.end(), arguments_.print_words.begin(), arguments_.print_words.end());
        return argv;
    }

    Vec3d place_of(const CheckedPrint& print, const Vec3d& voxel) const {
        const pipeline::PrintInfo& info = print.info;
        return {info.origin_mm.x + (voxel.x - 1) * info.pitch_mm.x,
                info.origin_mm.y + (voxel.y - 1) * info.pitch_mm.y,
                info.origin_mm.z + (voxel.z - 1 + info.slice_begin) * info.pitch_mm.z};
    }
    Vec3d at_of(const CheckedPrint& print, const Finding& finding) const {
        const Vec3i& p = finding.voxels.empty() ? finding.where.first
                                                : finding.voxels[finding.voxels.size() / 2];
        return place_of(print, {p.x + 0.5, p.y + 0.5, p.z + 0.5});
    }
    Box3d box_of(const CheckedPrint& print, const Finding& finding) const {
        const Box3i& b = finding.where.box;
        return {place_of(print, {double(b.lo.x), double(b.lo.y), double(b.lo.z)}),
                place_of(print, {double(b.hi.x), double(b.hi.y), double(b.hi.z)})};
    }

    void tell(const CheckedPrint& print, const std::vector<Finding>& found) const {
        constexpr int32_t kMostLines = 20;  // of each fault
        std::map<Fault, int32_t> counts;
        for (const Finding& finding : found) {
            if (++counts[finding.fault] > kMostLines) continue;
            const Vec3d at = at_of(print, finding);
            const Vec3d size = box_of(print, finding).size();
            const std::string of = finding.material.empty()
                                       ? ""
                                       : fmt::format(" of `{}`", printable(finding.material));
            const std::string limit =
                finding.fault == Fault::kTouch ? "" : fmt::format(" (limit {:.3g})", finding.limit);
            tell_line(fmt::format(messages::kFindingLine, name_of(finding.fault), finding.measure,
                                  unit_of(finding.fault), limit, of, at.x, at.y, at.z, size.x,
                                  size.y, size.z));
        }
        for (const auto& [fault, count] : counts) {
            if (count > kMostLines)
                tell_line(fmt::format(messages::kMoreFindings, name_of(fault), count - kMostLines,
                                      arguments_.report.empty() ? messages::kReportHasAll : ""));
        }
        if (found.empty() && !arguments_.before_print()) show(messages::kNothingFound);
    }
    void tell_line(const std::string& line) const {
        if (arguments_.before_print()) {
            say(line);
        } else {
            show(line);
        }
    }

    std::string report(const CheckedPrint& print, const std::vector<Finding>& found) const {
        JsonText json(JsonText::Layout::kIndented);
        const auto vector = [&](const char* name, const Vec3d& v) {
            json.key(name).begin_array().value(v.x).value(v.y).value(v.z).end_array();
        };
        json.begin_object();
        vector("voxel_mm", print.info.pitch_mm);
        json.member("parts", print.parts).key("findings").begin_array();
        for (const Finding& finding : found) {
            const Box3d box = box_of(print, finding);
            json.begin_object().member("fault", name_of(finding.fault));
            json.member("material", finding.material).member("measure", finding.measure);
            json.member("unit", unit_of(finding.fault)).member("limit", finding.limit);
            json.member("voxels", finding.where.voxels);
            vector("at_mm", at_of(print, finding));
            vector("from_mm", box.lo);
            vector("to_mm", box.hi);
            json.end_object();
        }
        return json.end_array().end_object().take() + "\n";
    }

    const CheckArguments& arguments_;
    const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
    int64_t memory_ = 0;
    int32_t draft_ = 1;  ///< of a world
    world::Printer printer_;
    std::optional<world::Checks> limits_;
    std::map<std::string, std::string> channels_;  ///< by material
    std::vector<fs::path> inputs_;
};

}  // namespace

Result<void> run_check(const CheckArguments& arguments) {
    return Checker(arguments).run();
}

}  // namespace openfab::tools

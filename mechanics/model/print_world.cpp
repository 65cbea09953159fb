// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/print_world.h"

#include <fmt/format.h>

#include <array>
#include <memory>

#include "base/check.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/say.h"
#include "base/talking_program.h"
#include "mechanics/messages.h"
#include "mechanics/model/absolute_paths.h"
#include "tools/viewer/child.h"
#include "tools/viewer/fablets.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostWorldBytes = 16 << 20;

Result<void> run(const std::vector<std::string>& argv, const fs::path& folder) {
    const fs::path err = folder / "print.err";
    Result<std::unique_ptr<viewer::Child>> child =
        viewer::Child::start(argv, folder / "print.out", err);
    if (!child) return child.error();
    const int code = (*child)->wait();
    if (code == 0) return {};
    // What it says has the form of our own messages.
    constexpr int64_t kMostSaid = 64 << 10;
    say(viewer::end_of_file(err, kMostSaid));
    for (const ErrorCode one :
         {ErrorCode::kUserInput, ErrorCode::kOutside, ErrorCode::kInterrupted})
        if (code == exit_code(one)) return Error{one, "", "", {}};
    return Error{ErrorCode::kInternal, "", "", {}};
}

std::string box_text(const std::array<double, 3>& mm) {
    return fmt::format("{{\"cell\": {{\"box\": [{}, {}, {}]}}}}", mm[0], mm[1], mm[2]);
}

Result<CellWorld> of_fablet(const fs::path& input, const std::array<double, 3>& cell_mm,
                            const fs::path& programs, const fs::path& scratch) {
    const viewer::FabletCompiler compiler(programs, scratch);
    const Result<std::vector<viewer::Diagnostic>> checked = compiler.check(input);
    if (!checked) return checked.error();
    for (const viewer::Diagnostic& one : *checked)
        if (one.severity == "error")
            return error_at({one.file.string(), one.line, one.column}, one.message);
    const auto described = compiler.describe(input);
    if (!described) return described.error();
    if (described->empty()) return user_error(fmt::format(messages::kNoFablet, input.string()));
    const auto& [name, fablet] = *described->begin();
    JsonText uniforms, materials;
    uniforms.begin_object();
    materials.begin_object();
    int number = 0;
    if (const JsonValue* list = member_of(fablet, "uniforms"))
        for (const JsonValue& one : list->items) {
            const JsonValue* kind = member_of(one, "kind");
            const JsonValue* uniform = member_of(one, "name");
            if (!kind || !uniform || kind->text != "material") continue;
            uniforms.member(uniform->text, uniform->text);
            materials.key(uniform->text).begin_object();
            materials.member("key", fmt::format("#{:06x}", 0x303030 + 0x2a1 * ++number));
            materials.end_object();
        }
    uniforms.end_object();
    materials.end_object();
    if (number == 0)
        return user_error(fmt::format(messages::kNoMaterialUniform, input.string(), name),
                          messages::kNoMaterialUniformHelp);
    JsonText source;
    source.value(fs::absolute(input).string());
    return CellWorld{
        fmt::format(
            "{{\"openfab\": 1, \"printer\": \"generic\", \"fablets\": {{\"cell\": {{\"source\": "
            "{}, "
            "\"fablet\": \"{}\"}}}}, \"materials\": {}, \"meshes\": {}, \"objects\": {{\"cell\": "
            "{{\"mesh\": \"cell\", \"fablet\": \"cell\", \"uniforms\": {}}}}}, \"build\": "
            "[{{\"object\": \"cell\"}}]}}",
            source.take(), name, materials.take(), box_text(cell_mm), uniforms.take()),
        "cell",
        {fs::absolute(input).parent_path()}};
}

}  // namespace

Result<fs::path> print_voxels(const PrintRequest& request, const fs::path& folder,
                              const std::string& name) {
    const fs::path file = folder / (name + ".npy");
    std::vector<std::string> argv{(request.programs / "openfab").string(),
                                  "print",
                                  as_argument(request.world),
                                  "--memory",
                                  fmt::format("{}B", request.memory_bytes),
                                  "--threads",
                                  std::to_string(request.threads),
                                  "--support",
                                  "off",
                                  "--progress",
                                  "none"};
    if (request.voxel_mm > 0)
        argv.insert(argv.end(), {"--voxel", fmt::format("{:.9g}mm", request.voxel_mm)});
    if (request.codes) {
        argv.insert(argv.end(), {"-o", file.string()});
        if (!request.dither.empty()) argv.insert(argv.end(), {"--dither", request.dither});
    } else {
        argv.insert(argv.end(), {"--fractions", file.string(), "--fractions-supersample",
                                 std::to_string(request.supersample)});
    }
    for (const std::string& one : request.allow)
        argv.push_back(allow_argument(one));
    for (const std::string& one : request.settings)
        argv.insert(argv.end(), {"--set", one});
    if (Result<void> done = run(argv, folder); !done) return done.error();
    return file;
}

Result<std::array<double, 3>> build_size(const PrintRequest& request, const fs::path& folder) {
    const fs::path file = folder / "estimate.json";
    std::vector<std::string> argv{(request.programs / "openfab").string(),
                                  "print",
                                  as_argument(request.world),
                                  "--estimate",
                                  "--stats",
                                  file.string(),
                                  "--voxel",
                                  "0.5mm"};
    for (const std::string& one : request.allow)
        argv.push_back(allow_argument(one));
    for (const std::string& one : request.settings)
        argv.insert(argv.end(), {"--set", one});
    if (Result<void> done = run(argv, folder); !done) return done.error();
    const Result<std::string> text = read_text_file(file, kMostWorldBytes);
    if (!text) return text.error();
    const Result<JsonValue> estimate = parse_json(*text, file.string());
    if (!estimate) return estimate.error();
    const JsonMember* size = estimate->find("size_voxels");
    const JsonMember* pitch = estimate->find("pitch_mm");
    OPENFAB_CHECK(size && pitch && size->value.items.size() == 3 && pitch->value.items.size() == 3);
    std::array<double, 3> out;
    for (size_t a = 0; a < 3; ++a)
        out[a] = size->value.items[a].number * pitch->value.items[a].number;
    return out;
}

Result<CellWorld> cell_world(const fs::path& input, const std::string& object,
                             const std::array<double, 3>& cell_mm, const fs::path& programs,
                             const fs::path& scratch) {
    if (input.extension() == ".fl") return of_fablet(input, cell_mm, programs, scratch);
    const Result<std::string> text = read_text_file(input, kMostWorldBytes);
    if (!text) return text.error();
    const Result<JsonValue> world = parse_json(*text, input.string());
    if (!world) return world.error();
    const JsonMember* objects = world->find("objects");
    const JsonMember* fablets = world->find("fablets");
    if (!objects || objects->value.members.empty() || !fablets)
        return user_error(fmt::format(messages::kNoObjectsIn, input.string()));
    const JsonMember* taken =
        object.empty() ? objects->value.members.data() : objects->value.find(object);
    if (!taken) return user_error(fmt::format(messages::kNoObjectIn, input.string(), object));
    const fs::path folder = fs::absolute(input).parent_path();
    JsonText out;
    out.begin_object().member("openfab", 1);
    for (const JsonMember& one : world->members) {
        if (one.key == "openfab" || one.key == "meshes" || one.key == "objects" ||
            one.key == "build" || one.key == "groups" || one.key == "arrange" ||
            one.key == "tray" || one.key == "$schema" || one.key == "cases")
            continue;
        out.key(one.key);
        write_absolute(one.value, folder, &out);
    }
    out.key("meshes").begin_object().key("cell").begin_object().key("box").begin_array();
    for (const double mm : cell_mm)
        out.value(mm);
    out.end_array().end_object().end_object();
    out.key("objects").begin_object().key(taken->key).begin_object().member("mesh", "cell");
    for (const JsonMember& one : taken->value.members)
        if (one.key == "fablet" || one.key == "uniforms" || one.key == "max_displacement_mm") {
            out.key(one.key);
            write_absolute(one.value, folder, &out);
        }
    out.end_object().end_object();
    out.key("build")
        .begin_array()
        .begin_object()
        .member("object", taken->key)
        .end_object()
        .end_array();
    out.end_object();
    return CellWorld{out.take(), taken->key, {reading_root(folder)}};
}

}  // namespace openfab::mechanics

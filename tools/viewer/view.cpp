// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/view.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/mman.h>

#include <cerrno>
#include <thread>

#include "base/input_file.h"
#include "base/json_text.h"
#include "base/messages.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/system_reason.h"
#include "tools/viewer/browser.h"
#include "tools/viewer/http_server.h"
#include "tools/viewer/live.h"
#include "tools/viewer/live_api.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/parameters.h"
#include "tools/viewer/part_finder.h"
#include "tools/viewer/print_api.h"
#include "tools/viewer/prober.h"
#include "tools/viewer/session.h"
#include "tools/viewer/viewer_page.h"
#include "world/world.h"

namespace openfab::viewer {

namespace {

/// Slices come and go in any order from many threads: their memory goes back to the system instead
/// of being kept in a heap for each thread.
void keep_memory_small() {
    constexpr int kLargeBlock = 1 << 20;
    constexpr int kMostHeaps = 4;
    ::mallopt(M_MMAP_THRESHOLD, kLargeBlock);
    ::mallopt(M_ARENA_MAX, kMostHeaps);
}

/// Of a world with `known`, the last state's "live"."change", once there is another.
Answer state(const Request& request, Session* session, const Live* live) {
    Parameters in(request);
    const int32_t known = in.whole_or("known", -1, 0, INT32_MAX);
    if (!in.failed().empty()) return refusal(400, in.failed());
    if (live != nullptr) live->wait_for_change(known);
    JsonText out;
    out.begin_object();
    // Its count comes first: prints may be newer than what it counts, never older.
    if (live != nullptr) live->describe(&out.key("live"));
    session->look_again();
    describe_prints(session->prints(), &out);
    out.end_object();
    return {200, "application/json", out.take()};
}

/// Checks that what a print was made from is a world, or a mesh with its fablet.
Result<void> check_origin(const ViewOptions& options) {
    const bool is_world = options.world.ends_with(".json");
    if (!options.fablet.empty() && (options.world.empty() || is_world)) {
        return usage_error(messages::kFabletIsForMesh);
    }
    if (options.world.empty() || is_world || !options.fablet.empty()) return {};
    return usage_error(fmt::format(messages::kWorldIsNoWorld, options.world));
}

/// Opens the prints; of a world there is none yet.
Result<void> open_prints(const ViewOptions& options, bool is_world, Session* session) {
    if (is_world) {
        if (!options.world.empty()) return usage_error(messages::kWorldIsForPrint);
        if (!options.fablet.empty()) return usage_error(messages::kFabletIsForPrint);
        if (!options.compare.empty()) return usage_error(messages::kWorldCannotBeCompared);
        // Whatever else is wrong with it can be mended while the page is open.
        const Result<InputFile> world = InputFile::open(options.file);
        if (world) return {};
        return with_context(world.error(), fmt::format(messages::kCannotOpen, options.file));
    }
    if (options.watch) return usage_error(messages::kWatchIsForWorld);
    if (options.world.empty() && (!options.settings.empty() || !options.allow.empty())) {
        return usage_error(messages::kSetIsForWorld);
    }
    if (Result<void> fits = check_origin(options); !fits) return fits;
    if (Result<void> opened = session->open(options.file); !opened) return opened;
    return options.compare.empty() ? Result<void>() : session->open(options.compare);
}

/// Reads the world that a print was made from. A mesh that was printed alone is its only part.
Result<void> know_world(const ViewOptions& options, std::unique_ptr<TemporaryFolder>* scratch,
                        OfWorld* out) {
    if (options.fablet.empty()) {
        Result<world::World> world =
            world::load_world(options.world, world::rules_of(options.allow, options.memory_bytes));
        if (!world) return world.error();
        const auto finder = std::make_shared<const PartFinder>(
            std::make_shared<const world::World>(std::move(*world)));
        out->part_at = [finder](const Vec3d& point_mm) { return finder->at(point_mm); };
    }
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    *scratch = std::move(*folder);
    const auto prober = std::make_shared<Prober>(options.programs, (*scratch)->path());
    const ProbedWorld probed{options.world, options.fablet, options.allow, options.settings};
    out->amounts_at = [prober, probed](const pipeline::PrintInfo& info, const Vec3d& point_mm) {
        return prober->fractions(probed, info, point_mm);
    };
    return {};
}

/// Where addresses are few (`ulimit -v`), threads find no stack, and programs do not start: told before there is an address
/// to go to.
Result<void> check_addresses() {
    constexpr size_t kRoom = 256 << 20;
    void* const room =
        ::mmap(nullptr, kRoom, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (room == MAP_FAILED)
        return outside_error(fmt::format(openfab::messages::kSystemRefuses, system_reason(errno)));
    ::munmap(room, kRoom);
    return {};
}

}  // namespace

Result<void> view(const ViewOptions& options) {
    keep_memory_small();
    if (Result<void> room = check_addresses(); !room) return room;
    Session session(options.memory_bytes);
    const bool is_world = options.file.ends_with(".json");
    if (Result<void> opened = open_prints(options, is_world, &session); !opened) return opened;
    std::unique_ptr<Live> live;
    std::unique_ptr<TemporaryFolder> scratch;
    OfWorld world;
    if (is_world) {
        Result<std::unique_ptr<Live>> started = Live::start(options, &session);
        if (!started) return started.error();
        live = std::move(*started);
        world.part_at = [&](const Vec3d& point_mm) { return live->part_at(point_mm); };
        world.amounts_at = [&](const pipeline::PrintInfo& info, const Vec3d& point_mm) {
            return live->fractions_at(info, point_mm);
        };
    } else if (!options.world.empty()) {
        if (Result<void> known = know_world(options, &scratch, &world); !known) return known;
    }
    const Handler handler = [&](const Request& request) -> Answer {
        if (request.path == "/api/state") return state(request, &session, live.get());
        if (std::optional<Answer> answer = answer_on_world(live.get(), request)) return *answer;
        if (std::optional<Answer> answer = answer_on_prints(session, world, request))
            return *answer;
        return refusal(404, messages::kNothingAtAddress);
    };
    std::string url;
    Result<std::unique_ptr<HttpServer>> server =
        HttpServer::listen({options.address, options.port, kViewerPage}, handler, &url);
    if (!server) return server.error();
    show(fmt::format("{}\n", url));
    if (Result<void> written = written_out(); !written) return written;
    if (!options.words.empty()) say(options.words);
    // It may wait for its browser.
    std::thread([url] { open_in_browser(url); }).detach();
    return (*server)->serve();
}

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The job array of docs/how-to/slurm.md, without Slurm: its tasks are run here, a stand-in of scontrol ends the task as
// Slurm does that queues it again, and what the parts are merged to is one print.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/scenes/scene_fixture.h"
#include "tests/scenes/walkthrough.h"

namespace openfab::testing {
namespace {

/// Takes seconds, so that a signal finds it at work.
constexpr const char* kSlow = R"(import pattern;
fablet Ball {
    @uniform { Material material; }

    @Volume(@varying { VolumeAttributes attr })
    {
        float sum = 0;
        for (int k = 0; k < 200; ++k) sum += fbm(attr.voxelCenter * (1 + 0.1 * k), 12);
        MaterialComposition mc;
        mc.Set(material, saturate(0.5 + sum));
        return mc;
    }
}
)";

/// A task runs until its print has slices, gets the signal, and is run again until it is done.
constexpr const char* kTasks = R"sh(
set -euo pipefail
export SLURM_ARRAY_JOB_ID=7 SLURM_ARRAY_TASK_COUNT=3
openfab print ball.fab.json -o whole.ofr --progress none
for task in 1 2 3; do
    export SLURM_ARRAY_TASK_ID=$task SLURM_JOB_ID=$((7 + task % 3))
    bash array.sh > said 2>&1 & shell=$!
    for i in $(seq 1000); do
        [ -s "part.$task.ofr" ] && [ "$(stat -c %s "part.$task.ofr")" -gt 3000 ] && break
        kill -0 "$shell" 2> /dev/null || break
        sleep 0.01
    done
    kill -USR1 "$shell" 2> /dev/null || true
    if wait "$shell"; then echo "task $task was not slow enough" >&2; continue; fi
    grep -q "continues from there" said && echo "interrupted $task"
    bash array.sh
done
openfab merge part.*.ofr --whole -o ball.ofr
cmp ball.ofr whole.ofr
)sh";

TEST(JobArray, GoesOnAfterItsTimeLimit) {
    ScratchFolder folder;
    const auto file_of = [](const std::string& page, const std::string& name) {
        const std::vector<Block> blocks = blocks_of(read_file(source_dir() / page));
        const auto at = std::find_if(blocks.begin(), blocks.end(),
                                     [&](const Block& block) { return block.file == name; });
        return at == blocks.end() ? std::string() : at->text;
    };
    folder.write("array.sh", file_of("docs/how-to/slurm.md", "array.sh"));
    folder.write("ball.fab.json", file_of("docs/how-to/several-machines.md", "ball.fab.json"));
    folder.write("ball.fl", kSlow);
    std::filesystem::create_directories(folder / "bin");
    // Ends the shell that asks, whose job it is.
    folder.write("bin/scontrol", "#!/bin/bash\necho \"$@\" >> scontrol.said\nkill -TERM $PPID\n");
    std::filesystem::permissions(folder / "bin/scontrol", std::filesystem::perms::owner_all);
    RunOptions options;
    options.folder = folder.path();
    options.environment = {
        {"PATH", (folder / "bin").string() + ":" + (build_dir() / "bin").string() +
                     ":/usr/local/bin:/usr/bin:/bin"},
        {"OPENFAB_CACHE", (folder / "cache").string()}};
    const Outcome outcome = run({"/bin/bash", "-c", kTasks}, options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
    // On a busy machine a task may end before the signal comes.
    EXPECT_THAT(outcome.out, ::testing::HasSubstr("interrupted")) << outcome.err;
    for (const char* task : {"1", "2", "3"}) {
        if (outcome.out.find(std::string("interrupted ") + task) == std::string::npos) continue;
        // Of this task alone: the number of a job may be that of the array.
        EXPECT_THAT(read_file(folder / "scontrol.said"),
                    ::testing::HasSubstr(std::string("requeue 7_") + task));
    }
}

}  // namespace
}  // namespace openfab::testing

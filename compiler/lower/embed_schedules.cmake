# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
# cmake -DSCHEDULES=folder -DOUTPUT=header -P embed_schedules.cmake: all schedule files as a C++ header.
file(GLOB files ${SCHEDULES}/*.sched)
list(SORT files)
set(text "// Generated from schedules/*.sched by embed_schedules.cmake.\n#pragma once\n\nnamespace openfab::lower {\n\n")
string(APPEND text "struct EmbeddedSchedule {\n    const char* name;\n    const char* text;\n};\n\n")
string(APPEND text "inline constexpr EmbeddedSchedule kEmbeddedSchedules[] = {\n")
foreach(file IN LISTS files)
    get_filename_component(name ${file} NAME)
    file(READ ${file} content)
    string(APPEND text "    {\"${name}\", R\"sched(${content})sched\"},\n")
endforeach()
string(APPEND text "};\n\n}  // namespace openfab::lower\n")
file(WRITE ${OUTPUT} "${text}")

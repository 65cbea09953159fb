# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
# Writes the printer profiles into a C++ file: cmake -DFOLDER=… -DOUTPUT=… -P embed_printers.cmake
file(GLOB profiles ${FOLDER}/*.printer.json)
list(SORT profiles)
set(entries "")
foreach(profile IN LISTS profiles)
    get_filename_component(file_name ${profile} NAME)
    string(REPLACE ".printer.json" "" name ${file_name})
    file(READ ${profile} text)
    string(APPEND entries "    {\"${name}\", R\"json(${text})json\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by embed_printers.cmake from world/printers/*.printer.json
#include \"world/printer_profiles.h\"

namespace openfab::scene {

const std::vector<PrinterProfile>& printer_profiles() {
    static const std::vector<PrinterProfile> profiles = {
${entries}    };
    return profiles;
}

}  // namespace openfab::scene
")

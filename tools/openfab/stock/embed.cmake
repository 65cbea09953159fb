# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
# Writes text files into a C++ file: cmake -DFILES=a;b -DOUTPUT=… -P embed.cmake
set(entries "")
foreach(file IN LISTS FILES)
    get_filename_component(name ${file} NAME)
    file(READ ${file} text)
    string(APPEND entries "    {\"${name}\", R\"stock(${text})stock\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by embed.cmake from tools/openfab/stock and the schema of worlds.
#include \"tools/openfab/stock.h\"

namespace openfab::tool {

const std::vector<StockText>& stock_texts() {
    static const std::vector<StockText> texts = {
${entries}    };
    return texts;
}

}  // namespace openfab::tool
")

# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# Makes and installs manual pages, completions of shells, and what Debian wants to lie in share/doc.
cmake_policy(VERSION 3.22)
find_program(python python3 REQUIRED)
set(share ${build}/install/share)
file(REMOVE_RECURSE ${share})
execute_process(COMMAND ${python} ${source}/cmake/command_manual.py --version ${version} ${build}/bin ${share} ${programs}
    COMMAND_ERROR_IS_FATAL ANY)
file(INSTALL ${share} DESTINATION ${CMAKE_INSTALL_PREFIX})
file(INSTALL ${source}/cmake/copyright DESTINATION ${CMAKE_INSTALL_PREFIX}/share/doc/openfab)

# Of SOURCE_DATE_EPOCH where that is set, as scripts/package does, so that the same build makes the same package.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(changelog ${build}/install/changelog)
file(WRITE ${changelog} "openfab (${version}) unstable; urgency=medium\n\n  * Made from the repository by scripts/package.\n\n"
    " -- ${contact}  ${date}\n")
execute_process(COMMAND gzip -9 --no-name --force ${changelog} COMMAND_ERROR_IS_FATAL ANY)
file(INSTALL ${changelog}.gz DESTINATION ${CMAKE_INSTALL_PREFIX}/share/doc/openfab)

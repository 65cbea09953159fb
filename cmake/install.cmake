# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# What `cmake --install` and scripts/package install. Programs find each other and the runtime relative to themselves
# (/proc/self/exe), so they have a prefix of their own with the layout of the build, lib/openfab/{bin,lib}; what is in the
# public bin/ are links to them. The whole works under any prefix and may be moved.
set(openfab_home lib/openfab)
set(openfab_programs openfab openflc openfab-texture openfab-text openfab-color openfab-render
    openfab-tuner openfab-fit openfab-mechanics)

# What these start where it was asked for: readers and writers that link optional libraries. Nobody types their names.
set(openfab_converters openfab-step openfab-vrml openfab-vdb openfab-texture-vdb openfab-texture-dicom openfab-texture-hdf5)
foreach(name IN LISTS openfab_converters)
    if(NOT TARGET ${name})
        list(REMOVE_ITEM openfab_converters ${name})
    endif()
endforeach()
add_custom_target(openfab_installed DEPENDS ${openfab_programs} ${openfab_converters})

install(TARGETS ${openfab_programs} ${openfab_converters} RUNTIME DESTINATION ${openfab_home}/bin)
foreach(name IN LISTS openfab_programs)
    file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/install)
    file(CREATE_LINK ../${openfab_home}/bin/${name} ${CMAKE_BINARY_DIR}/install/${name} SYMBOLIC)
    install(FILES ${CMAKE_BINARY_DIR}/install/${name} DESTINATION bin)
endforeach()

set(OPENFAB_PACKAGE_CONTACT "The OpenFab Authors <openfab@localhost>" CACHE STRING
    "Who made the package, with an address; scripts/package takes it from DEBFULLNAME and DEBEMAIL")

# The runtime that print programs are linked with; manual pages and completions, made from what the programs' --help says.
install(CODE "
    set(build \"${CMAKE_BINARY_DIR}\")
    set(source \"${CMAKE_SOURCE_DIR}\")
    set(home \"${openfab_home}\")
    set(programs \"${openfab_programs}\")
    set(version \"${PROJECT_VERSION}\")
    set(contact \"${OPENFAB_PACKAGE_CONTACT}\")
    set(objdump \"${CMAKE_OBJDUMP}\")
    set(system_folders \"${CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES}\")")
install(SCRIPT ${CMAKE_CURRENT_LIST_DIR}/install_runtime.cmake)
install(SCRIPT ${CMAKE_CURRENT_LIST_DIR}/install_manual.cmake)

# Compressors and parsers are linked statically on purpose: print programs run on machines that have nothing installed.
file(WRITE ${CMAKE_BINARY_DIR}/install/overrides "openfab: embedded-library expat *\nopenfab: embedded-library zlib *\n")
install(FILES ${CMAKE_BINARY_DIR}/install/overrides DESTINATION share/lintian/overrides RENAME openfab)

# To read: the library's sources, schedules to copy and change, the format of worlds.
install(DIRECTORY stdlib schedules DESTINATION share/openfab FILES_MATCHING PATTERN "*.fl" PATTERN "*.sched")
install(DIRECTORY world/printers DESTINATION share/openfab FILES_MATCHING PATTERN "*.json")
install(FILES world/fab_world.schema.json tools/fit/fab_fit.schema.json backends/job/fab_job.schema.json backends/job/fab_receive_log.schema.json DESTINATION share/openfab)
install(FILES README.md compiler/OPENFL.md world/WORLDS.md docs/streaming.md docs/streaming_client.py
    DESTINATION share/doc/openfab)
install(FILES schedules/README.md DESTINATION share/doc/openfab RENAME SCHEDULES.md)

# Worlds of the gallery, and the figures that several share.
install(FILES gallery/openfab.project DESTINATION share/doc/openfab/examples)
file(GLOB worlds CONFIGURE_DEPENDS gallery/*/*.fab.json)
foreach(world IN LISTS worlds)
    get_filename_component(folder ${world} DIRECTORY)
    file(RELATIVE_PATH name ${CMAKE_SOURCE_DIR}/gallery ${folder})
    install(FILES ${world} DESTINATION share/doc/openfab/examples/${name})
    list(APPEND example_folders ${name})
endforeach()
list(REMOVE_DUPLICATES example_folders)
install(FILES gallery/figures/zebra.png gallery/figures/reef.png DESTINATION share/doc/openfab/examples/figures)
list(APPEND example_folders figures)
foreach(name IN LISTS example_folders)
    file(GLOB files CONFIGURE_DEPENDS gallery/${name}/*.fl gallery/${name}/*.obj gallery/${name}/*.jpg
        gallery/${name}/*.csv gallery/${name}/*.nrrd gallery/${name}/*.vtu)
    install(FILES ${files} DESTINATION share/doc/openfab/examples/${name})
endforeach()

# scripts/package makes a .deb of all this.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME openfab)
set(CPACK_PACKAGE_VENDOR "The OpenFab Authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "programmable pipeline for voxel-level multi-material 3D printing")
set(CPACK_PACKAGE_DESCRIPTION "OpenFL is a language for what each voxel of a part is made of: a program
displaces the part's surface and mixes materials. openflc compiles such
programs through Halide; openfab prints worlds of meshes, pictures and
programs as slices at the resolution of the machine, in fixed memory: folders
of pictures, files, or a stream to a printer.")
set(CPACK_PACKAGE_CONTACT "${OPENFAB_PACKAGE_CONTACT}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
# Libraries are found by dpkg-shlibdeps. The table of a print program is compiled by `cc`, the program linked by `c++`.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "g++")
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
include(CPack)

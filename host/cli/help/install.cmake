# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` and `cpack` bring: the program, a manual page for each of its commands, completion for three shells, and a
# scene to begin with. Kernels are in the program, and nothing else is read at run time.
include(GNUInstallDirs)
install(TARGETS eikon)

# The program writes its pages and scripts itself, from the same text as --help.
set(written ${CMAKE_BINARY_DIR}/share)
add_custom_command(TARGET eikon POST_BUILD
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${written}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${written}/man1 ${written}/bash ${written}/zsh ${written}/fish
  COMMAND eikon man --folder ${written}/man1
  COMMAND eikon completion bash > ${written}/bash/eikon
  COMMAND eikon completion zsh > ${written}/zsh/_eikon
  COMMAND eikon completion fish > ${written}/fish/eikon.fish
  VERBATIM)
install(DIRECTORY ${written}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
install(FILES ${written}/bash/eikon DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${written}/zsh/_eikon DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${written}/fish/eikon.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(FILES scenes/cornell.gltf DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

# The package of Debian: `cpack -G DEB` in the build folder. Its dependencies are those libraries that the program is linked with,
# and any OpenCL driver, PoCL by default.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME eikon)
set(CPACK_PACKAGE_CONTACT "the authors of eikon <eikon@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "path tracer for glTF scenes that states its own error")
set(CPACK_PACKAGE_DESCRIPTION "eikon renders glTF 2.0 scenes on all OpenCL devices of a machine at once, CPUs\nthrough \
PoCL and any GPU, and writes OpenEXR images that hold a prediction of their\nown error. The image has the same bits whatever \
the devices.")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "pocl-opencl-icd | opencl-icd")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "bash-completion")
include(CPack)

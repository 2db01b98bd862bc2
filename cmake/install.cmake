# graintruth_install_library(NAME): the library and its headers under the prefix, for others' find_package(graintruth),
# which then offers graintruth::NAME. Only for libraries that others may build on. Component "development" is these alone.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/graintruth)

function(graintruth_install_library name)
  install(TARGETS ${name} graintruth_options EXPORT graintruth
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/graintruth COMPONENT development)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/graintruth/${name}
    COMPONENT development FILES_MATCHING PATTERN *.h)
endfunction()

install(EXPORT graintruth NAMESPACE graintruth:: FILE graintruth-targets.cmake
  DESTINATION ${package_folder} COMPONENT development)
file(WRITE ${CMAKE_BINARY_DIR}/graintruth-config.cmake "include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4 NO_MODULE)
include(\${CMAKE_CURRENT_LIST_DIR}/graintruth-targets.cmake)
")
write_basic_package_version_file(${CMAKE_BINARY_DIR}/graintruth-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/graintruth-config.cmake ${CMAKE_BINARY_DIR}/graintruth-config-version.cmake
  DESTINATION ${package_folder} COMPONENT development)

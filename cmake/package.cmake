# The Debian package that ./run package makes: what cmake --install installs, under /usr. Its dependencies are found from
# the libraries that the program is linked with.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME graintruth)
set(CPACK_PACKAGE_CONTACT "The Graintruth authors <graintruth@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "calibrates discrete-element parameters of grain from lab films")
set(CPACK_PACKAGE_DESCRIPTION "Tracks every particle on films of a granular experiment, compares the tracks with an embedded
multi-sphere simulator, tunes friction, restitution and time step until they agree, and writes a
report that says how well, and how sure.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "chromium, python3-numpy")  # report --pdf; import graintruth
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/debian/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "lammps, liggghts, yade")  # what export writes for
include(CPack)

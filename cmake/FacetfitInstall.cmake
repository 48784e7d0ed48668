# What others link: the umbrella target facetfit::facetfit, a CMake package and a pkg-config file, all relocatable.
include(CMakePackageConfigHelpers)
get_property(rooms GLOBAL PROPERTY FACETFIT_ROOMS)

add_library(facetfit_all INTERFACE)
add_library(facetfit::facetfit ALIAS facetfit_all)
foreach(room ${rooms})
  target_link_libraries(facetfit_all INTERFACE facetfit_${room})
endforeach()
set_target_properties(facetfit_all PROPERTIES EXPORT_NAME facetfit)
install(TARGETS facetfit_all EXPORT facetfit-targets)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/facetfit)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/facetfit-config.cmake.in ${PROJECT_BINARY_DIR}/facetfit-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/facetfit-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/facetfit-config.cmake ${PROJECT_BINARY_DIR}/facetfit-config-version.cmake DESTINATION ${package_dir})
install(EXPORT facetfit-targets NAMESPACE facetfit:: DESTINATION ${package_dir})

# pkg-config: highest room first, so that one pass of the linker resolves everything.
set(FACETFIT_PC_LIBS "")
foreach(room ${rooms})
  string(PREPEND FACETFIT_PC_LIBS "-lfacetfit_${room} ")
endforeach()
file(RELATIVE_PATH FACETFIT_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(${CMAKE_CURRENT_LIST_DIR}/facetfit.pc.in ${PROJECT_BINARY_DIR}/facetfit.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/facetfit.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/facetfit)
